"""Values of sensors that nobody may believe for ever. Pure.

Source: Home Assistant core 2025.4, ``expire_after`` in ``components/mqtt/sensor.py`` and ``binary_sensor.py``.
"""

from __future__ import annotations

from homebot.conventions.description import AutoExpiry
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity

__all__ = ["expire", "seconds_of"]


def expire(entity: Entity, config: DiscoveryConfig, capability: str) -> None:
    """Make *capability* unknown after the config's ``expire_after`` seconds; never where that is 0 or missing."""
    seconds = seconds_of(config, "expire_after")
    if seconds:
        entity.add_expiry(AutoExpiry(capability, seconds))


def seconds_of(config: DiscoveryConfig, key: str) -> float | None:
    """Return a time of the config; None where it is missing, or longer than ten years, which is for ever."""
    seconds = config.integer(key, _FOR_EVER, least=0)
    return float(seconds) if seconds < _FOR_EVER else None


_FOR_EVER = 10 * 366 * 86_400
