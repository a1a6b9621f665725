"""What a sensor's class and unit mean: which capability it measures, and how its numbers become the vocabulary's. Pure.

Source: Home Assistant core 2025.4, ``components/sensor/const.py`` and ``util/unit_conversion.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.capabilities import CAPABILITIES

__all__ = ["Quantity", "is_quantity", "quantity_of"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number says.

    Attributes:
        service_type: Of a part that measures only this.
        capability: Under which name it is reported.
        unit: Of the reported values: the vocabulary's, or the device's own where that cannot be converted.
        shift: Is taken from a number first.
        times: Then it is multiplied by this,
        over: and divided by this.
    """

    service_type: str
    capability: str
    unit: str
    shift: float = 0.0
    times: float = 1.0
    over: float = 1.0

    def value(self, number: float) -> float:
        """Return a device's *number* in :attr:`unit`."""
        return (number - self.shift) * self.times / self.over


def is_quantity(device_class: str) -> bool:
    """Tell whether a sensor of this class measures, even where it says nothing else."""
    return device_class in _CLASSES


@lru_cache(maxsize=512)
def quantity_of(device_class: str, unit: str) -> Quantity:
    """Return what a sensor of this class measures.

    Args:
        device_class: As its config has it; one that is not known, or none, is a ``measurement``.
        unit: As its config has it. None is the vocabulary's own; one that cannot be converted into that stays.
    """
    service_type, capability = _CLASSES.get(device_class, _OTHER)
    canonical = CAPABILITIES[capability].unit
    spelled = unit.strip().replace("\u03bc", "\u00b5").replace("\u2103", "°C").replace("\u2109", "°F")
    if not canonical or spelled in ("", canonical):
        return Quantity(service_type, capability, canonical or unit)
    conversion = _UNITS[capability].get(spelled) if capability in _UNITS else None
    if conversion is None:
        return Quantity(service_type, capability, unit)
    return Quantity(service_type, capability, canonical, *conversion)


_OTHER = ("x_sensor", "measurement")
_METER, _AIR = "electrical_meter", "air_quality_sensor"
_OF_THEIR_OWN = (
    "absolute_humidity",
    "area",
    "blood_glucose_concentration",
    "conductivity",
    "data_rate",
    "data_size",
    "distance",
    "duration",
    "energy_distance",
    "energy_storage",
    "gas",
    "irradiance",
    "monetary",
    "ph",
    "precipitation",
    "precipitation_intensity",
    "sound_pressure",
    "speed",
    "temperature_delta",
    "volume",
    "volume_storage",
    "water",
    "weight",
    "wind_direction",
    "wind_speed",
)
_CLASSES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(_OF_THEIR_OWN, _OTHER),
        "apparent_power": (_METER, "measurement"),
        "aqi": (_AIR, "air_quality_index"),
        "atmospheric_pressure": ("pressure_sensor", "pressure"),
        "battery": ("x_battery", "battery"),
        "carbon_dioxide": (_AIR, "carbon_dioxide"),
        "carbon_monoxide": (_AIR, "carbon_monoxide"),
        "current": (_METER, "current"),
        "energy": (_METER, "energy"),
        "frequency": ("x_sensor", "frequency"),
        "humidity": ("humidity_sensor", "humidity"),
        "illuminance": ("light_sensor", "illuminance"),
        "moisture": ("soil_sensor", "soil_moisture"),
        "nitrogen_dioxide": (_AIR, "measurement"),
        "nitrogen_monoxide": (_AIR, "measurement"),
        "nitrous_oxide": (_AIR, "measurement"),
        "ozone": (_AIR, "measurement"),
        "pm1": (_AIR, "pm1"),
        "pm10": (_AIR, "pm10"),
        "pm25": (_AIR, "pm25"),
        "pm4": (_AIR, "measurement"),
        "power": (_METER, "power"),
        "power_factor": (_METER, "measurement"),
        "pressure": ("pressure_sensor", "pressure"),
        "reactive_energy": (_METER, "measurement"),
        "reactive_power": (_METER, "measurement"),
        "signal_strength": ("x_sensor", "signal_strength"),
        "sulphur_dioxide": (_AIR, "measurement"),
        "temperature": ("temperature_sensor", "temperature"),
        "volatile_organic_compounds": (_AIR, "volatile_organic_compounds"),
        "volatile_organic_compounds_parts": (_AIR, "volatile_organic_compounds"),
        "voltage": (_METER, "voltage"),
        "volume_flow_rate": ("flow_sensor", "flow"),
    }
)
"""Class to service type and capability."""

_Conversion: TypeAlias = tuple[float, float, float]
_MILLI: _Conversion = (0.0, 1.0, 1e3)
_MICRO: _Conversion = (0.0, 1.0, 1e6)
_KILO: _Conversion = (0.0, 1e3, 1.0)
_MEGA: _Conversion = (0.0, 1e6, 1.0)
_SAME: _Conversion = (0.0, 1.0, 1.0)
_MASS_IN_AIR: Mapping[str, _Conversion] = {"mg/m³": _KILO, "ug/m³": _SAME, "ug/m3": _SAME, "\u00b5g/m3": _SAME}
_UNITS: Mapping[str, Mapping[str, _Conversion]] = MappingProxyType(
    {
        "current": {"mA": _MILLI, "\u00b5A": _MICRO, "kA": _KILO},
        "energy": {
            "mWh": (0.0, 1.0, 1e6),
            "Wh": _MILLI,
            "MWh": _KILO,
            "GWh": _MEGA,
            "TWh": (0.0, 1e9, 1.0),
            "J": (0.0, 1.0, 3.6e6),
            "kJ": (0.0, 1.0, 3.6e3),
            "MJ": (0.0, 1.0, 3.6),
            "GJ": (0.0, 1e3, 3.6),
            "cal": (0.0, 4.184, 3.6e6),
            "kcal": (0.0, 4.184, 3.6e3),
            "Mcal": (0.0, 4.184, 3.6),
            "Gcal": (0.0, 4184.0, 3.6),
        },
        "flow": {
            "L/h": _MILLI,
            "L/min": (0.0, 60.0, 1e3),
            "L/s": (0.0, 3.6, 1.0),
            "mL/s": (0.0, 3.6, 1e3),
            "m³/s": (0.0, 3600.0, 1.0),
            "m³/min": (0.0, 60.0, 1.0),
            "m3/h": _SAME,
            "ft³/min": (0.0, 60 * 0.028316846592, 1.0),
            "gal/min": (0.0, 60 * 0.003785411784, 1.0),
        },
        "frequency": {"mHz": _MILLI, "kHz": _KILO, "MHz": _MEGA, "GHz": (0.0, 1e9, 1.0)},
        "illuminance": {"lux": _SAME, "Lux": _SAME, "klx": _KILO},
        "power": {"mW": _MILLI, "kW": _KILO, "MW": _MEGA, "GW": (0.0, 1e9, 1.0), "TW": (0.0, 1e12, 1.0)},
        "pressure": {
            "Pa": (0.0, 1.0, 100.0),
            "kPa": (0.0, 10.0, 1.0),
            "MPa": (0.0, 1e4, 1.0),
            "mbar": _SAME,
            "cbar": (0.0, 10.0, 1.0),
            "bar": _KILO,
            "mmHg": (0.0, 1.333223874150, 1.0),
            "inHg": (0.0, 33.8638864034, 1.0),
            "psi": (0.0, 68.9475729317, 1.0),
        },
        "temperature": {
            "°F": (32.0, 1.0, 1.8),
            "F": (32.0, 1.0, 1.8),
            "K": (273.15, 1.0, 1.0),
            "C": _SAME,
        },
        "voltage": {"mV": _MILLI, "\u00b5V": _MICRO, "kV": _KILO, "MV": _MEGA},
        "pm1": _MASS_IN_AIR,
        "pm10": _MASS_IN_AIR,
        "pm25": _MASS_IN_AIR,
        "volatile_organic_compounds": _MASS_IN_AIR,
        "carbon_dioxide": {"ppb": _MILLI},
        "carbon_monoxide": {"ppb": _MILLI},
    }
)
"""Capability to unit to conversion into the vocabulary's unit."""
