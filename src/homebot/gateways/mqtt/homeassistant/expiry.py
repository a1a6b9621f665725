"""Values of sensors that nobody may believe for ever. Pure.

Source: Home Assistant core 2025.4, ``expire_after`` in ``components/mqtt/sensor.py`` and ``binary_sensor.py``.
"""

from __future__ import annotations

from homebot.gateways.mqtt.description import Fade
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.entity import Entity

__all__ = ["LONGEST", "expire"]

LONGEST = 10 * 366 * 86_400
"""Longest time, in seconds, after which a value ends by itself."""


def expire(entity: Entity, config: Config, capability: str) -> None:
    """Make *capability* unknown after the config's ``expire_after`` seconds; never where that is 0 or missing."""
    seconds = config.integer("expire_after", 0, least=0, most=LONGEST)
    if seconds:
        entity.fades(Fade(capability, float(seconds)))
