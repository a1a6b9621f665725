"""Device classes of Home Assistant, and of firmware for it, for sensors and covers. Pure.

Source: Home Assistant core 2025.4, ``components/sensor/const.py``, ``components/binary_sensor/__init__.py`` and
``components/cover/__init__.py``.
"""

from collections.abc import Mapping
from functools import lru_cache

from homebot.conventions.units import Quantity, conversion_of, measured_in, sensor_type
from homebot.devices.capabilities import CAPABILITIES

CLOSURE_CLASSES = frozenset({"damper", "door", "garage", "gate", "window"})
"""Device classes of covers that are closures, not window coverings."""


def is_quantity(device_class: str) -> bool:
    """Return whether the class alone identifies a sensor of numbers."""
    return device_class in _CLASSES


@lru_cache(maxsize=512)
def quantity_of(device_class: str, unit: str) -> Quantity:
    """Return the quantity of a sensor.

    Args:
        device_class: Its class; an unknown one is a ``measurement``, and an empty one what the unit alone measures.
        unit: Its unit; an empty one is the vocabulary's own, one of another class is trusted more than the class, as
            Tasmota 8 called volts ``power``, and one that fits neither makes it a ``measurement``.
    """
    service_type, capability = _CLASSES.get(device_class or measured_in(unit), _OTHER)
    canonical = CAPABILITIES[capability].unit
    if not canonical or not unit.strip():
        return Quantity(service_type, capability, canonical or unit)
    conversion = conversion_of(capability, unit)
    if conversion is None:
        return quantity_of("", unit) if measured_in(unit) else Quantity(*_OTHER, unit)
    return Quantity(service_type, capability, canonical, conversion)


def condition_of(device_class: str) -> tuple[str, str]:
    """Return service type and capability of a binary sensor; ``state`` for an unknown class."""
    return _CONDITIONS.get(device_class, _OTHER_CONDITION)


_OTHER = ("x_sensor", "measurement")
_METER, _AIR = "electrical_meter", "air_quality_sensor"
_OF_THEIR_OWN = (
    *("absolute_humidity", "area", "blood_glucose_concentration", "conductivity", "data_rate", "data_size"),
    *("distance", "duration", "energy_distance", "energy_storage", "gas", "irradiance", "monetary", "ph"),
    *("precipitation", "precipitation_intensity", "sound_pressure", "speed", "temperature_delta", "volume"),
    *("volume_storage", "water", "weight", "wind_direction", "wind_speed"),
)
_CALLED_ALIKE = (
    *("battery", "carbon_dioxide", "carbon_monoxide", "current", "energy", "humidity", "illuminance", "pm1"),
    *("pm10", "pm25", "power", "pressure", "signal_strength", "temperature", "volatile_organic_compounds"),
    *("voltage",),
)
_CLASSES: Mapping[str, tuple[str, str]] = {
    **{name: (sensor_type(name), name) for name in _CALLED_ALIKE},
    **dict.fromkeys(_OF_THEIR_OWN, _OTHER),
    **dict.fromkeys(("apparent_power", "power_factor", "reactive_energy", "reactive_power"), (_METER, "measurement")),
    **dict.fromkeys(
        ("nitrogen_dioxide", "nitrogen_monoxide", "nitrous_oxide", "ozone", "pm4", "sulphur_dioxide"),
        (_AIR, "measurement"),
    ),
    "aqi": (_AIR, "air_quality_index"),
    "atmospheric_pressure": ("pressure_sensor", "pressure"),
    "frequency": ("x_sensor", "frequency"),
    "moisture": ("soil_sensor", "soil_moisture"),
    "volatile_organic_compounds_parts": (_AIR, "volatile_organic_compounds"),
    **dict.fromkeys(("flow", "volume_flow_rate"), ("flow_sensor", "flow")),
}
"""Class to service type and capability."""

QUANTITY_CLASSES: Mapping[str, str] = {
    capability: name for name, (_, capability) in sorted(_CLASSES.items(), reverse=True) if capability != "measurement"
}
"""Class by capability."""

_CONDITIONS_CALLED_ALIKE = (
    *("connectivity", "gas", "heat", "moving", "occupancy", "problem", "running", "safety", "smoke", "sound"),
    *("tamper", "vibration"),
)
_OTHER_CONDITION = ("x_binary_sensor", "state")
_CONTACT = ("contact_sensor", "contact")
_OCCUPANCY = ("occupancy_sensor", "occupancy")
_CONDITIONS: Mapping[str, tuple[str, str]] = {
    **{name: (sensor_type(name), name) for name in _CONDITIONS_CALLED_ALIKE},
    "battery": ("x_battery", "battery_low"),
    "battery_charging": ("x_battery", "battery_charging"),
    "carbon_monoxide": ("smoke_co_alarm", "carbon_monoxide_alarm"),
    "cold": ("water_freeze_detector", "freeze"),
    "door": _CONTACT,
    "garage_door": _CONTACT,
    "glass_break": (sensor_type("tamper"), "tamper"),
    "light": ("x_binary_sensor", "light_detected"),
    "lock": ("x_binary_sensor", "unlocked"),
    "moisture": ("water_leak_detector", "water_leak"),
    "motion": _OCCUPANCY,
    "opening": _CONTACT,
    "plug": ("x_binary_sensor", "plugged_in"),
    "power": ("x_binary_sensor", "power_detected"),
    "presence": _OCCUPANCY,
    "update": ("x_update", "update_available"),
    "window": _CONTACT,
}
"""Class to service type and capability."""

CONDITION_CLASSES: Mapping[str, tuple[str, ...]] = {
    capability: tuple(sorted(condition for condition in _CONDITIONS if _CONDITIONS[condition][1] == capability))
    for capability in {capability for _, capability in _CONDITIONS.values()}
}
"""Classes by capability."""
