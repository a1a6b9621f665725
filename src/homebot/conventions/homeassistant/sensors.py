"""The components ``sensor`` and ``binary_sensor``, and the capabilities by their device classes. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt`` (``sensor.py``, ``binary_sensor.py``) and ``const.py`` and
``__init__.py`` of ``components/sensor`` and ``components/binary_sensor``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from functools import lru_cache, partial
from types import MappingProxyType

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.conversion import read_number
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import clean_text
from homebot.conventions.units import Quantity, conversion_of
from homebot.devices.capabilities import CAPABILITIES

__all__ = [
    "CONDITION_CLASSES",
    "QUANTITY_CLASSES",
    "build_binary_sensor",
    "build_sensor",
    "expire",
    "is_quantity",
    "quantity_of",
    "seconds_of",
]


def is_quantity(device_class: str) -> bool:
    """Tell whether a sensor of this class measures, even where it says nothing else."""
    return device_class in _SENSOR_CLASSES


@lru_cache(maxsize=512)
def quantity_of(device_class: str, unit: str) -> Quantity:
    """Return what a sensor of this class measures.

    Args:
        device_class: As its config has it; one that is not known, or none, is a ``measurement``.
        unit: As its config has it. None is the vocabulary's own; one that cannot be converted into that stays.
    """
    service_type, capability = _SENSOR_CLASSES.get(device_class, _SENSOR_OTHER)
    canonical = CAPABILITIES[capability].unit
    if not canonical or not unit.strip():
        return Quantity(service_type, capability, canonical or unit)
    conversion = conversion_of(capability, unit)
    if conversion is None:
        return Quantity(service_type, capability, unit)
    return Quantity(service_type, capability, canonical, conversion)


_SENSOR_OTHER = ("x_sensor", "measurement")
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
_SENSOR_CLASSES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(_OF_THEIR_OWN, _SENSOR_OTHER),
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

QUANTITY_CLASSES: Mapping[str, str] = MappingProxyType(
    {
        capability: name
        for name, (_, capability) in sorted(_SENSOR_CLASSES.items(), reverse=True)
        if capability != "measurement"
    }
)
"""The other way round: the class that says a capability."""


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


def build_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor: of numbers where class, unit or statistics say so, and else of texts.

    A number is reported in the unit of the vocabulary; where its own cannot be converted, in that. One of a class that
    we do not know has a meaning of its own.
    """
    source = config.required_source("state_topic").without_payload()
    device_class = config.clean_text("device_class")
    if device_class not in _TEXTS and (is_quantity(device_class) or any(config.has(key) for key in _NUMERIC)):
        quantity = quantity_of(device_class, config.clean_text("unit_of_measurement", _MAX_UNIT))
        entity = Entity(config, quantity.service_type)
        if entity.read_text_from(source, partial(_read_number, quantity)):
            entity.add_capability(quantity.capability, unit=quantity.unit)
            expire(entity, config, quantity.capability)
        return entity.build()
    entity = Entity(config, "x_sensor")
    options = config.options("options")
    read = _MOMENTS.get(device_class) or partial(_read_text, frozenset(options))
    if entity.read_text_from(source, read):
        entity.add_capability("value", options=options)
        expire(entity, config, "value")
    return entity.build()


_TEXTS = frozenset({"date", "enum", "timestamp"})
_NUMERIC = ("unit_of_measurement", "state_class", "suggested_display_precision")
_MAX_TEXT = 255
_MAX_UNIT = 40


def _read_number(quantity: Quantity, text: str) -> Readings:
    return read_number(quantity.capability, text, convert=quantity.value)


def _read_text(options: frozenset[str], text: str) -> Readings:
    if text == "None":
        return _UNKNOWN
    if len(text) > _MAX_TEXT or (options and text not in options):
        return NO_READINGS
    return {"value": clean_text(text, _MAX_TEXT)}


def _read_date(text: str) -> Readings:
    moment = _moment(text)
    return {"value": moment.date().isoformat()} if moment else _UNKNOWN


def _read_timestamp(text: str) -> Readings:
    """A moment without time zone tells nothing: nobody knows which it is."""
    moment = _moment(text)
    if moment is None:
        return _UNKNOWN
    try:
        return {"value": moment.astimezone(UTC).isoformat(timespec="seconds")} if moment.tzinfo else NO_READINGS
    except OverflowError:
        return NO_READINGS


def _moment(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text[:_MAX_TEXT])
    except ValueError:
        return None


_UNKNOWN: Readings = {"value": None}
_MOMENTS: Mapping[str, Callable[[str], Readings]] = {"date": _read_date, "timestamp": _read_timestamp}


def build_binary_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor of one condition; its class says which. One of no known class has a ``state``."""
    source = config.required_source("state_topic")
    service_type, capability = _CONDITION_CLASSES.get(config.clean_text("device_class"), _CONDITION_OTHER)
    states: dict[str, bool | None] = {
        "None": None,
        config.text("payload_off", "OFF"): False,
        config.text("payload_on", "ON"): True,
    }

    def read(text: str) -> Readings:
        return {capability: states[text]} if text in states and text.strip() else NO_READINGS

    entity = Entity(config, service_type)
    if entity.read_text_from(source, read):
        entity.add_capability(capability)
        delay = seconds_of(config, "off_delay")
        if delay is not None:
            entity.add_expiry(AutoExpiry(capability, delay, value=False, only=True))
        expire(entity, config, capability)
    return entity.build()


_CONDITION_OTHER = ("x_binary_sensor", "state")
_CONTACT = ("contact_sensor", "contact")
_OCCUPANCY = ("occupancy_sensor", "occupancy")
_CONDITION_CLASSES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
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
)
"""Class to service type and to what is so when the sensor is on."""

CONDITION_CLASSES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        capability: tuple(sorted(one for one in _CONDITION_CLASSES if _CONDITION_CLASSES[one][1] == capability))
        for capability in {capability for _, capability in _CONDITION_CLASSES.values()}
    }
)
"""The other way round: the classes that say a capability."""
