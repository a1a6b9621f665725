"""Damaged announcements and messages of ``shelly``: refused in our words, or understood."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from homebot.conventions.shelly import Shelly, ShellySettings

if TYPE_CHECKING:
    from tests.fuzz.conftest import Fuzz


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz, devices: Callable[[str], list[dict[str, Any]]]) -> None:
    fuzz.convention("shelly", lambda: Shelly(ShellySettings()), devices("shelly"))
