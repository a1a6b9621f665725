"""Thermostats and air conditioners that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > climate. Temperatures are in °C.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import JsonPart, PartBuilder
from homebot.conventions.payload import clean_text
from homebot.conventions.table_codec import json_object
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.conventions.zigbee2mqtt.features import add_enum, add_number
from homebot.conventions.zigbee2mqtt.program import add_mode

__all__ = ["FEATURES_OF_CLIMATE", "build_climate", "build_thermometer", "climate_type"]


def climate_type(climate: Expose) -> str:
    """Return the service type: what cools and can dry or only blow is an air conditioner."""
    mode = climate.feature("system_mode")
    modes = set(mode.options) if mode is not None else set()
    return "room_air_conditioner" if "cool" in modes and modes & {"dry", "fan_only"} else "thermostat"


def build_climate(part: JsonPart, topics: Zigbee2MqttTopics, climate: Expose, program: Expose | None) -> DescribedPart:
    """Describe a thermostat.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        climate: What it exposes.
        program: The enum that says whether it follows its program; None where it has none.
    """
    for capability, names in _NUMBERS.items():
        add_number(part, topics, climate.feature(*names), capability)
    mode = climate.feature("system_mode")
    if mode is not None and program is not None:
        add_mode(part, topics, mode, program)
    else:
        add_enum(part, topics, mode, "thermostat_mode")
    for capability, name in _ENUMS.items():
        add_enum(part, topics, climate.feature(name), capability)
    add_enum(part, topics, climate.feature("running_state"), "thermostat_action", _ACTIONS)
    part.add_state_request(*topics.request_state(*(one for one in climate.features if one.name in FEATURES_OF_CLIMATE)))
    return part.build()


def build_thermometer(topics: Zigbee2MqttTopics, climate: Expose) -> DescribedPart | None:
    """Describe the thermometer in a thermostat, for who asks how warm it is; None where it has none."""
    local = climate.feature("local_temperature")
    if local is None or not local.is_published:
        return None
    part = PartBuilder(
        json_object, clean_text(local.key), "temperature_sensor", name=local.label, advertised=local.name
    )
    add_number(part, topics, local, "temperature")
    return part.build()


_NUMBERS: Mapping[str, tuple[str, ...]] = {
    "local_temperature": ("local_temperature",),
    "heating_setpoint": ("occupied_heating_setpoint", "current_heating_setpoint"),
    "cooling_setpoint": ("occupied_cooling_setpoint",),
}
_ENUMS: Mapping[str, str] = {
    "fan_mode": "fan_mode",
    "swing_mode": "swing_mode",
    "preset_mode": "preset",
}
_ACTIONS: Mapping[str, str] = {"idle": "idle", "heat": "heating", "cool": "cooling", "fan_only": "fan"}

FEATURES_OF_CLIMATE = frozenset(
    {"running_state", "system_mode", *_ENUMS.values(), *(name for names in _NUMBERS.values() for name in names)}
)
