"""The component ``binary_sensor``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/binary_sensor.py`` and ``components/binary_sensor/__init__.py``.
"""

from __future__ import annotations

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.device_classes import condition_of
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import meaning_reader

__all__ = ["build_binary_sensor"]


def build_binary_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor of one condition; its class says which. One of no known class has a ``state``."""
    source = config.required_source("state_topic")
    service_type, capability = condition_of(config.clean_text("device_class"))
    states: dict[str, bool | None] = {
        "None": None,
        config.text("payload_off", "OFF"): False,
        config.text("payload_on", "ON"): True,
    }

    read = meaning_reader(capability, {text: state for text, state in states.items() if text.strip()})
    entity = Entity(config, service_type)
    if entity.read_text_from(source, read):
        entity.add_capability(capability)
        delay = config.seconds("off_delay")
        if delay is not None:
            entity.add_expiry(AutoExpiry(capability, delay, value=False, only=True))
        entity.expire(capability)
    return entity.build()
