"""Single properties as capabilities: how each is read, and how it is told. Pure."""

from __future__ import annotations

from collections.abc import Callable

from homebot.conventions.command_values import Writer, require_bool, require_number
from homebot.conventions.description import Publication
from homebot.conventions.homie.model import HomieProperty
from homebot.conventions.homie.values import is_unknown_number, publication, read_plain, spell_plain
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.conventions.units import Conversion, celsius_bounds, conversion_of, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = [
    "add_enum",
    "add_flag",
    "add_percent",
    "add_plain",
    "add_press",
    "add_temperature",
    "percent_of",
    "percent_written",
]

_FAHRENHEIT = frozenset({"F", "°F"})
_PERCENT = 100.0
_ANY_CELSIUS = (-273.15, 1e6)
_DIGITS = 3


def add_plain(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Let *prop* be *capability* as it is, in the vocabulary's unit."""
    conversion = conversion_of(capability, prop.unit) or Conversion()

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        if value is None:
            return _unread(capability, prop, payload)
        return {capability: conversion.value(value) if isinstance(value, float) else value}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (publication(prop, spell_plain(prop, capability, value)),)

    _add_reader(part, prop, read)
    part.add_capability(
        capability,
        readable=prop.is_retained or not prop.is_settable,
        writer=_writer(part, prop, write),
        unit=prop.unit if capability in {"number", "measurement"} else "",
        bounds=_bounds(prop) if capability == "number" else (),
        options=prop.options if prop.datatype == "enum" else (),
    )


def add_press(part: BytesPart, prop: HomieProperty) -> None:
    """Let *prop* tell presses: the words of an enum, or a truth."""

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        if isinstance(value, bool):
            return {"press": "single"} if value else NO_READINGS
        return {"press": value} if isinstance(value, str) else NO_READINGS

    part.read_events_from(prop.topic, read)
    part.add_capability("press", options=("single",) if prop.datatype == "boolean" else prop.options)


def add_flag(part: BytesPart, prop: HomieProperty) -> None:
    """Let *prop* be whether the part is on."""

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        return {"on_off": value} if isinstance(value, bool) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (publication(prop, "true" if require_bool("on_off", value) else "false"),)

    _add_reader(part, prop, read)
    part.add_capability("on_off", readable=prop.is_retained, writer=_writer(part, prop, write))


def add_percent(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Let *prop* be *capability* in percent of its range."""

    def read(payload: bytes) -> Readings:
        percent = percent_of(prop, payload)
        return _unread(capability, prop, payload) if percent is None else {capability: percent}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (percent_written(prop, capability, require_number(capability, value, 0, _PERCENT, "%")),)

    _add_reader(part, prop, read)
    part.add_capability(capability, readable=prop.is_retained, writer=_writer(part, prop, write))


def add_temperature(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Let *prop* be *capability* in degrees Celsius."""
    is_fahrenheit = prop.unit.strip() in _FAHRENHEIT

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        if not isinstance(value, float):
            return _unread(capability, prop, payload)
        return {capability: to_celsius(value, _DIGITS) if is_fahrenheit else value}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        least, most = bounds or _ANY_CELSIUS
        celsius = require_number(capability, value, least, most, "°C")
        number = to_fahrenheit(celsius, _DIGITS) if is_fahrenheit else celsius
        return (publication(prop, spell_plain(prop, capability, prop.range.kept(number) if bounds else number)),)

    ends = _bounds(prop)
    bounds = celsius_bounds(*ends) if ends and is_fahrenheit else ends
    _add_reader(part, prop, read)
    part.add_capability(capability, writer=_writer(part, prop, write), bounds=bounds if prop.is_settable else ())


def add_enum(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Let the words of *prop* be *capability*, in small letters."""
    options = {option.casefold(): option for option in prop.options}

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        return {capability: value.casefold()} if isinstance(value, str) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if not isinstance(value, str) or value not in options:
            raise RefusedError(f"{capability} {shown(value)}", f"it takes {', '.join(list(options)[:20])}")
        return (publication(prop, options[value]),)

    _add_reader(part, prop, read)
    part.add_capability(
        capability, readable=prop.is_retained, writer=_writer(part, prop, write), options=tuple(options)
    )


def percent_of(prop: HomieProperty, payload: bytes) -> float | None:
    """Return what *payload* tells of *prop* in percent of its range."""
    value = read_plain(prop, payload)
    if not isinstance(value, float):
        return None
    least, most = _ends(prop)
    percent = round((value - least) * _PERCENT / (most - least), 6)
    return percent if 0 <= percent <= _PERCENT else None


def percent_written(prop: HomieProperty, capability: str, percent: float) -> Publication:
    """Return what tells *prop* to be *percent* of its range; below its smallest value, that."""
    least, most = _ends(prop)
    value = least + (most - least) * percent / _PERCENT
    if prop.range.least is not None:
        value = max(value, prop.range.least)
    return publication(prop, spell_plain(prop, capability, value))


def _ends(prop: HomieProperty) -> tuple[float, float]:
    """Return the numbers for 0 % and 100 %. A range from 1 leaves out the 0, which means off."""
    least = prop.range.least or 0.0
    most = _PERCENT if prop.range.most is None else prop.range.most
    if least == 1.0 and most > 1.0:
        least = 0.0
    return (least, most) if most > least else (0.0, _PERCENT)


def _unread(capability: str, prop: HomieProperty, payload: bytes) -> Readings:
    """Read a payload that is no value: the number is unknown, or nothing is said."""
    return {capability: None} if is_unknown_number(prop, payload) else NO_READINGS


def _bounds(prop: HomieProperty) -> tuple[float, float] | tuple[()]:
    least, most = prop.range.least, prop.range.most
    return (least, most) if least is not None and most is not None else ()


def _add_reader(part: BytesPart, prop: HomieProperty, read: Callable[[bytes], Readings]) -> None:
    if prop.is_retained:
        part.read_from(prop.topic, read)
    elif not prop.is_settable:
        part.read_events_from(prop.topic, read)


def _writer(part: BytesPart, prop: HomieProperty, write: Writer) -> Writer | None:
    if not prop.is_settable:
        return None
    part.add_command_topics(f"{prop.topic}/set")
    return write
