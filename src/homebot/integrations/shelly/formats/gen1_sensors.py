"""Meters and sensors of Shelly's first generation, and devices that report all in one ``status``. Pure.

Source: Shelly Gen1 API, MQTT, also of Motion and TRV; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from homebot.conventions.command_values import number_writer
from homebot.conventions.description import Publication, Publications
from homebot.conventions.part_builder import BytesPart, JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, percent_of, read_number, to_json, to_text
from homebot.conventions.probe_errors import DS18X20_RESET, read_probe
from homebot.conventions.units import sensor_type, to_celsius, to_fahrenheit
from homebot.conventions.unreadable import unreadable
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.integrations.shelly.formats.status import Fields, StatusDecoder, reader_of
from homebot.support.numbers import to_number


@dataclass(frozen=True, slots=True)
class Gen1Sensor:
    """A value with a topic of its own.

    Attributes:
        suffix: Its topic below the device's; without the number of a channel.
        is_number: Whether other payloads are numbers; outside of *least* and *most* they are *unknown*.
        unit: The unit, if the capability has none.
        service_type: The service type, if it differs from the usual one of the capability.
    """

    suffix: str
    capability: str
    values: Mapping[str, PlainValue] = field(default_factory=dict)
    is_number: bool = False
    least: float = -1e12
    most: float = 1e12
    category: Category = ""
    unit: str = ""
    service_type: str = ""

    def read(self, payload: bytes) -> Readings:
        """Read *payload*; never raises."""
        text = to_text(payload) or ""
        if text in self.values:
            return {self.capability: self.values[text]}
        if not self.is_number:
            return unreadable(text, self.values)
        readings = read_number(self.capability, text)
        number = readings.get(self.capability)
        is_out = isinstance(number, float) and not self.least <= number <= self.most
        if is_out:
            return {self.capability: None}
        # home-assistant/core#177168; the other probe of the add-on, a DHT22, ends at 80 °C
        return read_probe(readings, DS18X20_RESET) if self.suffix == "ext_temperature" else readings


_FLAG_VALUES: Mapping[str, PlainValue] = {"true": True, "false": False, "1": True, "0": False, "-1": None}
_MAX_CELSIUS = 998.0
"""A broken or missing sensor reports 999."""

_DOORS: Mapping[str, PlainValue] = {"open": True, "close": False, "unknown": None}
_GASES: Mapping[str, PlainValue] = {"none": False, "mild": True, "heavy": True, "test": None, "unknown": None}

SENSORS: Mapping[str, Gen1Sensor] = {
    sensor.suffix: sensor
    for sensor in (
        Gen1Sensor("sensor/state", "contact", _DOORS),
        Gen1Sensor("sensor/motion", "occupancy", _FLAG_VALUES),
        Gen1Sensor("sensor/flood", "water_leak", _FLAG_VALUES),
        Gen1Sensor("sensor/smoke", "smoke", _FLAG_VALUES),
        Gen1Sensor("sensor/gas", "gas", _GASES),
        Gen1Sensor("sensor/temperature", "temperature", is_number=True, most=_MAX_CELSIUS),
        Gen1Sensor("sensor/humidity", "humidity", is_number=True, least=0, most=100),
        Gen1Sensor("sensor/lux", "illuminance", is_number=True, least=0),
        Gen1Sensor("sensor/concentration", "measurement", is_number=True, least=0, unit="ppm"),
        Gen1Sensor("sensor/tilt", "measurement", is_number=True, least=0, unit="°"),
        Gen1Sensor("sensor/vibration", "vibration", _FLAG_VALUES),
        Gen1Sensor("sensor/battery", "battery", is_number=True, least=0, most=100, category="diagnostic"),
        Gen1Sensor("sensor/charger", "battery_charging", _FLAG_VALUES, category="diagnostic", service_type="x_battery"),
        Gen1Sensor("temperature", "temperature", is_number=True, most=_MAX_CELSIUS, category="diagnostic"),
        Gen1Sensor("overtemperature", "heat", _FLAG_VALUES, category="diagnostic"),
        Gen1Sensor("overpower", "problem", _FLAG_VALUES, category="diagnostic"),
        Gen1Sensor("ext_temperature", "temperature", is_number=True, most=_MAX_CELSIUS),
        Gen1Sensor("ext_humidity", "humidity", is_number=True, least=0, most=100),
        Gen1Sensor("ext_switch", "state", _FLAG_VALUES),
    )
}
"""By :attr:`Gen1Sensor.suffix`; the main purpose of a device comes first."""

_METERED: Mapping[str, tuple[str, float]] = {
    "power": ("power", 1.0),
    "energy": ("energy", 1 / 60_000),
    "total": ("energy", 1 / 1000),
    "total_returned": ("energy_returned", 1 / 1000),
    "voltage": ("voltage", 1.0),
    "current": ("current", 1.0),
}
"""Capability and factor of the topics of a meter; Shelly counts watt-minutes or watt-hours."""


def build_sensor(base: str, sensor: Gen1Sensor, index: int | None = None) -> BytesPart:
    """Describe a sensor, or channel *index* of one."""
    part_id = sensor.suffix.removeprefix("sensor/")
    topic = f"{base}/{sensor.suffix}"
    if index is not None:
        part_id, topic = f"{part_id}:{index}", f"{topic}/{index}"
    service_type = sensor.service_type or sensor_type(sensor.capability)
    part = BytesPart(part_id, service_type, advertised=sensor.suffix, category=sensor.category)
    if sensor.suffix == "sensor/temperature":
        is_fahrenheit = False

        def read_info(payload: bytes) -> Readings:
            nonlocal is_fahrenheit
            status = as_fields(to_json(payload))
            is_fahrenheit = as_fields(status.get("tmp")).get("units") == "F"
            return _read_temperature(sensor.capability, status)

        def read(payload: bytes) -> Readings:
            readings = sensor.read(payload)
            number = readings.get(sensor.capability)
            return {sensor.capability: to_celsius(number)} if is_fahrenheit and isinstance(number, float) else readings

        part.read_from(topic, read)
        part.read_from(f"{base}/info", read_info)
        part.remembers()
    else:
        part.read_from(topic, sensor.read)
    part.add_capability(sensor.capability, unit=sensor.unit)
    return part


def build_meter(base: str, part_id: str, suffixes: Mapping[str, str]) -> BytesPart:
    """Describe a meter; *suffixes* are its topics by the names in ``_METERED``."""
    part = BytesPart(part_id, "electrical_meter", advertised="meter")
    for name, suffix in suffixes.items():
        capability, factor = _METERED[name]
        part.read_from(f"{base}/{suffix}", partial(_read_measure, capability, factor))
        part.add_capability(capability)
    return part


def _read_measure(capability: str, factor: float, payload: bytes) -> Readings:
    text = to_text(payload)
    return NO_READINGS if text is None else read_number(capability, text, lambda number: number * factor)


_VALVE_BOUNDS = (4.0, 31.0)


def build_motion(base: str, *, has_thermometer: bool) -> tuple[JsonPart, ...]:
    """Describe the values in the one ``status`` of a motion sensor."""
    return tuple(
        _status_part(base, part_id, capability, decode)
        for part_id, capability, decode in _MOTION
        if has_thermometer or capability != "temperature"
    )


def build_valve(base: str) -> tuple[JsonPart, ...]:
    """Describe a radiator valve. Its commands are in the unit of its reports."""
    topic = f"{base}/thermostat/0/command/target_t"
    is_fahrenheit = False

    def read(status: Fields) -> Readings:
        nonlocal is_fahrenheit
        listed = status.get("thermostats")
        valve = as_fields(listed[0]) if isinstance(listed, list) and listed else status
        target = as_fields(valve.get("target_t"))
        setpoint = _read_degrees("heating_setpoint", target)
        if setpoint:
            is_fahrenheit = target.get("units") == "F"
        position = {"position": percent_of(valve["pos"])} if to_number(valve.get("pos")) is not None else {}
        return {**setpoint, **_read_temperature("local_temperature", valve), **position}

    def set_target(celsius: float) -> Publications:
        degrees = to_fahrenheit(celsius) if is_fahrenheit else celsius
        return (Publication(topic, f"{round(degrees, 1):g}".encode()),)

    part = JsonPart("thermostat:0", "thermostat", commands=topic, advertised="thermostat", tag="radiator_valve")
    part.read_from(f"{base}/status", read)
    part.read_from(f"{base}/info", read)
    writer = number_writer("heating_setpoint", _VALVE_BOUNDS, "°C", set_target)
    part.add_capability("heating_setpoint", writer=writer, bounds=_VALVE_BOUNDS)
    part.add_capability("local_temperature")
    part.add_capability("position")
    return part, _status_part(base, "battery", "battery", _read_battery)


def _read_battery(status: Fields) -> Readings:
    return reader_of("bat.value" if isinstance(status.get("bat"), dict) else "bat", "battery")(status)


def _read_temperature(capability: str, status: Fields) -> Readings:
    temperature = as_fields(status.get("tmp"))
    return {capability: None} if temperature.get("is_valid") is False else _read_degrees(capability, temperature)


def _read_degrees(capability: str, fields: Fields) -> Readings:
    number = to_number(fields.get("value"))
    if number is None:
        return NO_READINGS
    return {capability: to_celsius(number) if fields.get("units") == "F" else number}


_MOTION: tuple[tuple[str, str, StatusDecoder], ...] = (
    ("motion", "occupancy", reader_of("motion", "occupancy")),
    ("vibration", "vibration", reader_of("vibration", "vibration")),
    ("lux", "illuminance", reader_of("lux", "illuminance")),
    ("temperature", "temperature", partial(_read_temperature, "temperature")),
    ("battery", "battery", _read_battery),
)


def _status_part(base: str, part_id: str, capability: str, decode: StatusDecoder) -> JsonPart:
    is_battery = part_id == "battery"
    category: Category = "diagnostic" if is_battery else ""
    part = JsonPart(part_id, sensor_type(capability), advertised="status", category=category)
    for topic in ("status", "info") if is_battery else ("status",):
        part.read_from(f"{base}/{topic}", decode)
    part.add_capability(capability)
    return part
