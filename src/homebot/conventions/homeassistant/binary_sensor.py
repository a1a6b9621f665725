"""The component ``binary_sensor``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/binary_sensor.py`` and ``components/binary_sensor/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import meaning_reader

__all__ = ["CONDITION_CLASSES", "build_binary_sensor"]


def build_binary_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor of one condition; its class says which. One of no known class has a ``state``."""
    source = config.required_source("state_topic")
    service_type, capability = _CLASSES.get(config.clean_text("device_class"), _OTHER)
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


_OTHER = ("x_binary_sensor", "state")
_CONTACT = ("contact_sensor", "contact")
_OCCUPANCY = ("occupancy_sensor", "occupancy")
_CLASSES: Mapping[str, tuple[str, str]] = {
    "battery": ("x_battery", "battery_low"),
    "battery_charging": ("x_battery", "battery_charging"),
    "carbon_monoxide": ("smoke_co_alarm", "carbon_monoxide_alarm"),
    "cold": ("water_freeze_detector", "freeze"),
    "connectivity": ("x_binary_sensor", "connectivity"),
    "door": _CONTACT,
    "garage_door": _CONTACT,
    "gas": ("smoke_co_alarm", "gas"),
    "heat": ("x_binary_sensor", "heat"),
    "light": ("x_binary_sensor", "light_detected"),
    "lock": ("x_binary_sensor", "unlocked"),
    "moisture": ("water_leak_detector", "water_leak"),
    "motion": _OCCUPANCY,
    "moving": ("x_binary_sensor", "moving"),
    "occupancy": _OCCUPANCY,
    "opening": _CONTACT,
    "plug": ("x_binary_sensor", "plugged_in"),
    "power": ("x_binary_sensor", "power_detected"),
    "presence": _OCCUPANCY,
    "problem": ("x_binary_sensor", "problem"),
    "running": ("x_binary_sensor", "running"),
    "safety": ("x_binary_sensor", "safety"),
    "smoke": ("smoke_co_alarm", "smoke"),
    "sound": ("x_binary_sensor", "sound"),
    "tamper": ("x_binary_sensor", "tamper"),
    "update": ("x_update", "update_available"),
    "vibration": ("x_binary_sensor", "vibration"),
    "window": _CONTACT,
}
"""Class to service type and to what is so when the sensor is on."""

CONDITION_CLASSES: Mapping[str, tuple[str, ...]] = {
    capability: tuple(sorted(one for one in _CLASSES if _CLASSES[one][1] == capability))
    for capability in {capability for _, capability in _CLASSES.values()}
}
"""The other way round: the classes that say a capability."""
