"""What the names and units of Zigbee2MQTT's sensors are in our vocabulary: tables. Pure.

Source: zigbee2mqtt.io, Usage > Exposes; zigbee-herdsman-converters 26.105.0 for the names in use.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["CONDITIONS", "TRUE_IS_CLOSED", "Measure", "measure"]

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


@dataclass(frozen=True, slots=True)
class Measure:
    """What a number is.

    Attributes:
        service_type: Of the part that says it.
        capability: Which it is.
        unit: In which it is given on the graph; empty where the vocabulary says.
        factor: What the device's number is multiplied by.
        offset: What is added then.
    """

    service_type: str
    capability: str
    unit: str = ""
    factor: float = 1.0
    offset: float = 0.0


def measure(name: str, unit: str) -> Measure:
    """Return what the number *name* in *unit* is; a plain measurement where that is not known for sure."""
    capability = _NAMES.get(name) or _capability_of(name, unit)
    if capability in _UNITS and unit in _UNITS[capability]:
        factor, offset = _UNITS[capability][unit]
        return Measure(_SERVICES[capability], capability, factor=factor, offset=offset)
    return Measure(_SERVICES_OF_PLAIN.get(name, "x_sensor"), "measurement", unit)


_AIR = "air_quality_sensor"
_METER = "electrical_meter"

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

_SERVICES: Mapping[str, str] = {
    "air_quality_index": _AIR,
    "battery": "x_battery",
    "carbon_monoxide": _AIR,
    "carbon_dioxide": _AIR,
    "current": _METER,
    "energy": _METER,
    "flow": "flow_sensor",
    "frequency": _METER,
    "humidity": "humidity_sensor",
    "illuminance": "light_sensor",
    "pm1": _AIR,
    "pm10": _AIR,
    "pm25": _AIR,
    "power": _METER,
    "pressure": "pressure_sensor",
    "soil_moisture": "soil_sensor",
    "temperature": "temperature_sensor",
    "volatile_organic_compounds": _AIR,
    "voltage": _METER,
}

_DUST = {"µg/m³": (1.0, 0.0), "μg/m³": (1.0, 0.0), "ug/m3": (1.0, 0.0), "mg/m³": (1_000.0, 0.0)}
_UNITS: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "air_quality_index": {"": (1.0, 0.0)},
    "battery": {"%": (1.0, 0.0)},
    "carbon_monoxide": {"ppm": (1.0, 0.0)},
    "carbon_dioxide": {"ppm": (1.0, 0.0)},
    "current": {"A": (1.0, 0.0), "mA": (0.001, 0.0)},
    "energy": {"kWh": (1.0, 0.0), "Wh": (0.001, 0.0), "MWh": (1_000.0, 0.0)},
    "flow": {"m³/h": (1.0, 0.0), "L/h": (0.001, 0.0), "L/min": (0.06, 0.0)},
    "frequency": {"Hz": (1.0, 0.0)},
    "humidity": {"%": (1.0, 0.0)},
    "illuminance": {"lx": (1.0, 0.0)},
    "pm1": _DUST,
    "pm10": _DUST,
    "pm25": _DUST,
    "power": {"W": (1.0, 0.0), "kW": (1_000.0, 0.0), "mW": (0.001, 0.0)},
    "pressure": {"hPa": (1.0, 0.0), "mbar": (1.0, 0.0), "kPa": (10.0, 0.0), "Pa": (0.01, 0.0)},
    "soil_moisture": {"%": (1.0, 0.0)},
    "temperature": {"°C": (1.0, 0.0), "°F": (5 / 9, -160 / 9)},
    "volatile_organic_compounds": _DUST,
    "voltage": {"V": (1.0, 0.0), "mV": (0.001, 0.0)},
}
"""Factor and offset from each unit to the vocabulary's, by capability."""

_BY_UNIT_ALONE = ("power", "energy", "current", "voltage", "frequency")
_BY_WORD = ("temperature", "humidity")
_NO_READINGS = frozenset(
    {"limit", "setpoint", "target", "calibration", "offset", "max", "min", "threshold", "alarm", "deadzone"}
)
"""Words in the names of numbers that are set, not measured."""


def _capability_of(name: str, unit: str) -> str:
    """Electrical units tell what is measured; degrees and percent do not without the name."""
    for capability in _BY_UNIT_ALONE:
        if unit in _UNITS[capability]:
            return capability
    words = set(re.split(r"[^a-z]+", re.sub(r"([A-Z])", r"_\1", name).lower()))
    if words & _NO_READINGS:
        return ""
    return next((one for one in _BY_WORD if one in words), "")
