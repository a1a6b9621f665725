"""Meters and sensors of Shelly's first generation, and devices that report all in one ``status``. Pure.

Source: Shelly Gen1 API, MQTT, also of Motion and TRV; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from homebot.conventions.command_values import require_number
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings, read_number, to_json, to_text
from homebot.conventions.shelly.gen1_models import Gen1Topics
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["SENSORS", "Gen1Sensor", "build_meter", "build_motion", "build_sensor", "build_valve"]


@dataclass(frozen=True, slots=True)
class Gen1Sensor:
    """A value with a topic of its own.

    Attributes:
        suffix: Its topic below the device's; where it has channels, without the number.
        service_type: See :attr:`homebot.devices.Part.service_type`.
        capability: See :data:`homebot.devices.capabilities.CAPABILITIES`.
        values: What each payload means.
        is_number: Whether a payload that is none of *values* is a number.
        least: Smallest number that can be.
        most: Largest number that can be; another is *unknown*.
        category: See :attr:`homebot.devices.Part.category`.
        unit: Where the capability has none.
    """

    suffix: str
    service_type: str
    capability: str
    values: Mapping[str, PlainValue] = field(default_factory=dict)
    is_number: bool = False
    least: float = -1e12
    most: float = 1e12
    category: Category = ""
    unit: str = ""

    def read(self, payload: bytes) -> Readings:
        """Return what *payload* tells; never raises."""
        text = to_text(payload) or ""
        if text in self.values:
            return {self.capability: self.values[text]}
        if not self.is_number:
            return NO_READINGS
        found = read_number(self.capability, text)
        number = found.get(self.capability)
        is_out = isinstance(number, float) and not self.least <= number <= self.most
        return {self.capability: None} if is_out else found


_FLAG_VALUES: Mapping[str, PlainValue] = MappingProxyType(
    {"true": True, "false": False, "1": True, "0": False, "-1": None}
)
_MOST_CELSIUS = 998.0
"""A sensor that is broken or absent says 999."""

_TABLE = (
    Gen1Sensor("sensor/state", "contact_sensor", "contact", {"open": True, "close": False, "unknown": None}),
    Gen1Sensor("sensor/motion", "occupancy_sensor", "occupancy", _FLAG_VALUES),
    Gen1Sensor("sensor/flood", "water_leak_detector", "water_leak", _FLAG_VALUES),
    Gen1Sensor("sensor/smoke", "smoke_co_alarm", "smoke", _FLAG_VALUES),
    Gen1Sensor(
        "sensor/gas",
        "smoke_co_alarm",
        "gas",
        {"none": False, "mild": True, "heavy": True, "unknown": None},
    ),
    Gen1Sensor("sensor/temperature", "temperature_sensor", "temperature", is_number=True, most=_MOST_CELSIUS),
    Gen1Sensor("sensor/humidity", "humidity_sensor", "humidity", is_number=True, least=0, most=100),
    Gen1Sensor("sensor/lux", "light_sensor", "illuminance", is_number=True, least=0),
    Gen1Sensor("sensor/concentration", "x_sensor", "measurement", is_number=True, least=0, unit="ppm"),
    Gen1Sensor("sensor/tilt", "x_sensor", "measurement", is_number=True, least=0, unit="°"),
    Gen1Sensor("sensor/vibration", "x_binary_sensor", "vibration", _FLAG_VALUES),
    Gen1Sensor("sensor/battery", "x_battery", "battery", is_number=True, least=0, most=100, category="diagnostic"),
    Gen1Sensor("sensor/charger", "x_battery", "battery_charging", _FLAG_VALUES, category="diagnostic"),
    Gen1Sensor(
        "temperature", "temperature_sensor", "temperature", is_number=True, most=_MOST_CELSIUS, category="diagnostic"
    ),
    Gen1Sensor("overtemperature", "x_binary_sensor", "heat", _FLAG_VALUES, category="diagnostic"),
    Gen1Sensor("overpower", "x_binary_sensor", "problem", _FLAG_VALUES, category="diagnostic"),
    Gen1Sensor("ext_temperature", "temperature_sensor", "temperature", is_number=True, most=_MOST_CELSIUS),
    Gen1Sensor("ext_humidity", "humidity_sensor", "humidity", is_number=True, least=0, most=100),
    Gen1Sensor("ext_switch", "x_binary_sensor", "state", _FLAG_VALUES),
)

SENSORS: Mapping[str, Gen1Sensor] = MappingProxyType({sensor.suffix: sensor for sensor in _TABLE})
"""By :attr:`Gen1Sensor.suffix`; first what a device is there for."""

_METERED: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "power": ("power", 1.0),
        "energy": ("energy", 1 / 60_000),
        "total": ("energy", 1 / 1000),
        "total_returned": ("energy_returned", 1 / 1000),
        "voltage": ("voltage", 1.0),
        "current": ("current", 1.0),
    }
)
"""The capability of what a meter tells, and what makes its unit of Shelly's: watt-minutes, watt-hours."""


def build_sensor(topics: Gen1Topics, sensor: Gen1Sensor, index: int | None = None) -> BytesPart:
    """Describe a sensor; where it is a channel, channel *index*."""
    part_id = sensor.suffix.removeprefix("sensor/")
    topic = topics.at(sensor.suffix)
    if index is not None:
        part_id, topic = f"{part_id}:{index}", f"{topic}/{index}"
    part = BytesPart(part_id, sensor.service_type, advertised=sensor.suffix, category=sensor.category)
    part.read_from(topic, sensor.read)
    part.add_capability(sensor.capability, unit=sensor.unit)
    return part


def build_meter(topics: Gen1Topics, part_id: str, suffixes: Mapping[str, str]) -> BytesPart:
    """Describe a meter.

    Args:
        topics: Those of its device.
        part_id: Of the part.
        suffixes: Topics below the device's, by what is told there: power, energy, total, total_returned, voltage,
            current.
    """
    part = BytesPart(part_id, "electrical_meter", advertised="meter")
    for name, suffix in suffixes.items():
        capability, factor = _METERED[name]
        part.read_from(topics.at(suffix), _measuring(capability, factor))
        part.add_capability(capability)
    return part


def _measuring(capability: str, factor: float) -> Callable[[bytes], Readings]:
    def read(payload: bytes) -> Readings:
        text = to_text(payload)
        return NO_READINGS if text is None else read_number(capability, text, lambda number: number * factor)

    return read


_VALVE_BOUNDS = (4.0, 31.0)
_UNCLEAR = object()


def build_motion(topics: Gen1Topics) -> tuple[BytesPart, ...]:
    """Describe what a motion sensor tells in its one ``status``."""
    return tuple(
        _status_part(topics, part_id, service_type, capability, find, category)
        for part_id, service_type, capability, find, category in _MOTION
    )


def build_valve(topics: Gen1Topics) -> tuple[BytesPart, ...]:
    """Describe a radiator valve."""
    topic = topics.at("thermostat/0/command/target_t")

    def heat(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        celsius = require_number("heating_setpoint", value, *_VALVE_BOUNDS, "°C")
        return (Publication(topic, f"{round(celsius, 1):g}".encode()),)

    part = BytesPart("thermostat:0", "thermostat", advertised="thermostat", tag="radiator_valve")
    part.read_from(topics.at("status"), _read_valve)
    part.read_from(topics.at("info"), _read_valve)
    part.add_command_topics(topic)
    part.add_capability("heating_setpoint", writer=heat, bounds=_VALVE_BOUNDS)
    part.add_capability("local_temperature")
    part.add_capability("position")
    return part, _status_part(topics, "battery", "x_battery", "battery", _battery, "diagnostic")


def _flag(status: Mapping[str, object], name: str) -> PlainValue | object:
    value = status.get(name)
    return value if isinstance(value, bool) else _UNCLEAR


def _number(value: object) -> PlainValue | object:
    number = to_number(value)
    return _UNCLEAR if number is None else number


def _battery(status: Mapping[str, object]) -> PlainValue | object:
    battery = status.get("bat")
    return _number(battery.get("value") if isinstance(battery, dict) else battery)


def _temperature(status: Mapping[str, object]) -> PlainValue | object:
    temperature = status.get("tmp")
    if not isinstance(temperature, dict):
        return _UNCLEAR
    return None if temperature.get("is_valid") is False else _number(temperature.get("value"))


_Find = Callable[[Mapping[str, object]], PlainValue | object]
_MOTION: tuple[tuple[str, str, str, _Find, Category], ...] = (
    ("motion", "occupancy_sensor", "occupancy", lambda status: _flag(status, "motion"), ""),
    ("vibration", "x_binary_sensor", "vibration", lambda status: _flag(status, "vibration"), ""),
    ("lux", "light_sensor", "illuminance", lambda status: _number(status.get("lux")), ""),
    ("temperature", "temperature_sensor", "temperature", _temperature, ""),
    ("battery", "x_battery", "battery", _battery, "diagnostic"),
)


def _status_part(
    topics: Gen1Topics, part_id: str, service_type: str, capability: str, find: _Find, category: Category
) -> BytesPart:
    def read(payload: bytes) -> Readings:
        status = to_json(payload)
        value = find(status) if isinstance(status, dict) else _UNCLEAR
        return {capability: value} if value is None or isinstance(value, (bool, float)) else NO_READINGS

    part = BytesPart(part_id, service_type, advertised="status", category=category)
    for topic in ("status", "info") if part_id == "battery" else ("status",):
        part.read_from(topics.at(topic), read)
    part.add_capability(capability)
    return part


def _read_valve(payload: bytes) -> Readings:
    status = to_json(payload)
    if not isinstance(status, dict):
        return NO_READINGS
    listed = status.get("thermostats")
    valve = listed[0] if isinstance(listed, list) and listed and isinstance(listed[0], dict) else status
    found: dict[str, PlainValue] = {}
    target = valve.get("target_t")
    setpoint = to_number(target.get("value")) if isinstance(target, dict) else None
    if setpoint is not None:
        found["heating_setpoint"] = setpoint
    temperature = _temperature(valve)
    if temperature is None or isinstance(temperature, float):
        found["local_temperature"] = temperature
    opened = to_number(valve.get("pos"))
    if opened is not None:
        found["position"] = opened if 0 <= opened <= 100 else None
    return found
