"""Devices of Shelly's first generation that tell all in one ``status``: motion sensors and radiator valves. Pure.

Source: Shelly Gen1 API, MQTT of Motion and TRV; iobroker.shelly 12.0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from homebot.conventions.command_values import require_number
from homebot.conventions.decode import NO_READINGS, Readings, to_json
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.table_codec import raw_bytes
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["build_motion", "build_valve"]

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

    part = PartBuilder(raw_bytes, "thermostat:0", "thermostat", advertised="thermostat", tag="radiator_valve")
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

    part = PartBuilder(raw_bytes, part_id, service_type, advertised="status", category=category)
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
