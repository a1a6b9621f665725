"""Meters and sensors of Shelly's first generation. Pure.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from homebot.conventions.decode import NO_READINGS, Readings, read_number, to_text
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.table_codec import raw_bytes
from homebot.devices.part import Category
from homebot.devices.value import PlainValue

__all__ = ["SENSORS", "Gen1Sensor", "build_meter", "build_sensor"]


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
    part = PartBuilder(raw_bytes, part_id, sensor.service_type, advertised=sensor.suffix, category=sensor.category)
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
    part = PartBuilder(raw_bytes, part_id, "electrical_meter", advertised="meter")
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
