"""Capabilities by the device class of a sensor. Pure.

Source: Home Assistant core 2025.4, ``components/sensor/const.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from homebot.conventions.units import Quantity, conversion_of
from homebot.devices.capabilities import CAPABILITIES

__all__ = ["QUANTITY_CLASSES", "is_quantity", "quantity_of"]


def is_quantity(device_class: str) -> bool:
    """Return whether a sensor of this class measures, even where it says nothing else."""
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
    if not canonical or not unit.strip():
        return Quantity(service_type, capability, canonical or unit)
    conversion = conversion_of(capability, unit)
    if conversion is None:
        return Quantity(service_type, capability, unit)
    return Quantity(service_type, capability, canonical, conversion)


_OTHER = ("x_sensor", "measurement")
_METER, _AIR = "electrical_meter", "air_quality_sensor"
_OF_THEIR_OWN = (
    *("absolute_humidity", "area", "blood_glucose_concentration", "conductivity", "data_rate", "data_size"),
    *("distance", "duration", "energy_distance", "energy_storage", "gas", "irradiance", "monetary", "ph"),
    *("precipitation", "precipitation_intensity", "sound_pressure", "speed", "temperature_delta", "volume"),
    *("volume_storage", "water", "weight", "wind_direction", "wind_speed"),
)
_CLASSES: Mapping[str, tuple[str, str]] = {
    **dict.fromkeys(_OF_THEIR_OWN, _OTHER),
    **dict.fromkeys(("apparent_power", "power_factor", "reactive_energy", "reactive_power"), (_METER, "measurement")),
    **dict.fromkeys(
        ("nitrogen_dioxide", "nitrogen_monoxide", "nitrous_oxide", "ozone", "pm4", "sulphur_dioxide"),
        (_AIR, "measurement"),
    ),
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
    "pm1": (_AIR, "pm1"),
    "pm10": (_AIR, "pm10"),
    "pm25": (_AIR, "pm25"),
    "power": (_METER, "power"),
    "pressure": ("pressure_sensor", "pressure"),
    "signal_strength": ("x_sensor", "signal_strength"),
    "temperature": ("temperature_sensor", "temperature"),
    "volatile_organic_compounds": (_AIR, "volatile_organic_compounds"),
    "volatile_organic_compounds_parts": (_AIR, "volatile_organic_compounds"),
    "voltage": (_METER, "voltage"),
    "volume_flow_rate": ("flow_sensor", "flow"),
}
"""Class to service type and capability."""

QUANTITY_CLASSES: Mapping[str, str] = {
    capability: name for name, (_, capability) in sorted(_CLASSES.items(), reverse=True) if capability != "measurement"
}
"""The other way round: the class that says a capability."""
