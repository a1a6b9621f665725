"""Actions of vacuum cleaners, mowers and locks, by the state that each commands. Pure.

Source: Home Assistant core 2025.4, ``components``: ``const.py`` of lawn_mower, lock and vacuum.
"""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["LOCK_STATES", "MOWER_ACTIONS", "MOWER_STATES", "VACUUM_ACTIONS", "VACUUM_STATES"]

LOCK_STATES = ("unlocked", "locked", "unlocking", "open", "locking", "opening", "jammed")

MOWER_ACTIONS: Mapping[str, tuple[int, str]] = {
    "mowing": (1, "start_mowing"),
    "paused": (2, "pause"),
    "docked": (4, "dock"),
}
"""The bit of ``supported_features`` that each needs, and its name."""

MOWER_STATES = (*MOWER_ACTIONS, "returning", "error")

VACUUM_ACTIONS: Mapping[str, tuple[int, str]] = {
    "cleaning": (8192, "start"),
    "paused": (4, "pause"),
    "idle": (8, "stop"),
    "returning": (16, "return_to_base"),
    "spot": (1024, "clean_spot"),
}
"""As :data:`MOWER_ACTIONS`."""

VACUUM_STATES = ("cleaning", "docked", "paused", "idle", "returning", "error")
