"""Names and units of Zigbee2MQTT's sensors, and our capabilities for them: tables. Pure.

Source: zigbee2mqtt.io, Usage > Exposes; zigbee-herdsman-converters 26.105.0 for the names in use.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from homebot.conventions.units import SENSOR_TYPES, Quantity, conversion_of

__all__ = ["CONDITIONS", "TRUE_IS_CLOSED", "measure"]

CONDITIONS: Mapping[str, tuple[str, str]] = {
    "contact": ("contact_sensor", "contact"),
    "garage_door_contact": ("contact_sensor", "contact"),
    "window": ("contact_sensor", "contact"),
    "window_open": ("contact_sensor", "contact"),
    "valve_state": ("contact_sensor", "contact"),
    "occupancy": ("occupancy_sensor", "occupancy"),
    "presence": ("occupancy_sensor", "occupancy"),
    "area1Occupancy": ("occupancy_sensor", "occupancy"),
    "area2Occupancy": ("occupancy_sensor", "occupancy"),
    "area3Occupancy": ("occupancy_sensor", "occupancy"),
    "area4Occupancy": ("occupancy_sensor", "occupancy"),
    "smoke": ("smoke_co_alarm", "smoke"),
    "carbon_monoxide": ("smoke_co_alarm", "carbon_monoxide_alarm"),
    "gas": ("smoke_co_alarm", "gas"),
    "water_leak": ("water_leak_detector", "water_leak"),
    "rain": ("rain_sensor", "rain"),
    "rain_status": ("rain_sensor", "rain"),
    "battery_low": ("x_battery", "battery_low"),
    "is_charging": ("x_battery", "battery_charging"),
    "tamper": ("x_binary_sensor", "tamper"),
    "vibration": ("x_binary_sensor", "vibration"),
    "noise_detected": ("x_binary_sensor", "sound"),
    "moving": ("x_binary_sensor", "moving"),
    "running": ("x_binary_sensor", "running"),
    "valve_alarm": ("x_binary_sensor", "problem"),
    "sos": ("x_binary_sensor", "safety"),
    "consumer_connected": ("x_binary_sensor", "plugged_in"),
    "is_plug_connected": ("x_binary_sensor", "plugged_in"),
}
"""Service type and capability of a binary that is said and cannot be set; true is what its ``value_on`` says."""

TRUE_IS_CLOSED = frozenset({"garage_door_contact"})
"""Binaries whose ``value_on`` is true where it should be false: what they say is whether the contact is closed."""


def measure(name: str, unit: str) -> Quantity:
    """Return what the number *name* in *unit* is; a plain measurement where that is not known for sure."""
    capability = _NAMES.get(name) or _capability_of(name, unit)
    conversion = conversion_of(capability, unit) if capability else None
    if conversion is None:
        return Quantity(_SERVICES_OF_PLAIN.get(name, "x_sensor"), "measurement", unit)
    return Quantity(SENSOR_TYPES[capability], capability, "", conversion)


_AIR = "air_quality_sensor"

_NAMES: Mapping[str, str] = {
    "aqi": "air_quality_index",
    "battery": "battery",
    "battery2": "battery",
    "co": "carbon_monoxide",
    "co2": "carbon_dioxide",
    "dew_point": "temperature",
    "flow": "flow",
    "illuminance": "illuminance",
    "pm1": "pm1",
    "pm10": "pm10",
    "pm25": "pm25",
    "pressure": "pressure",
    "soil_moisture": "soil_moisture",
    "voc": "volatile_organic_compounds",
}
_SERVICES_OF_PLAIN: Mapping[str, str] = {"voc": _AIR, "eco2": _AIR, "voc_index": _AIR}

_BY_UNIT_ALONE = ("power", "energy", "current", "voltage", "frequency")
_BY_NAME = ("temperature", "humidity")
_NO_READINGS = frozenset(
    {"limit", "setpoint", "target", "calibration", "offset", "max", "min", "threshold", "alarm", "deadzone"}
)
"""Words in the names of numbers that are set, not measured."""


def _capability_of(name: str, unit: str) -> str:
    """Electrical units tell what is measured; degrees and percent do not without the name."""
    for capability in _BY_UNIT_ALONE:
        if conversion_of(capability, unit) is not None:
            return capability
    tokens = set(re.split(r"[^a-z]+", re.sub(r"([A-Z])", r"_\1", name).lower()))
    if tokens & _NO_READINGS:
        return ""
    return next((one for one in _BY_NAME if one in tokens), "")
