"""Readers and writers of single properties. Pure."""

from __future__ import annotations

from collections.abc import Callable

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import Publication, Publications
from homebot.conventions.homie.model import HomieProperty
from homebot.conventions.homie.values import is_unknown_number, publication, read_plain, spell_plain
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.conventions.units import Conversion, celsius_bounds, conversion_of, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue

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
    """Add *capability* with the value of *prop*, in the vocabulary's unit."""
    conversion = conversion_of(capability, prop.unit) or Conversion()
    _add(
        part,
        capability,
        prop,
        lambda value: conversion.value(value) if isinstance(value, float) else value,
        lambda value: spell_plain(prop, capability, value),
        readable=prop.is_retained or not prop.is_settable,
        unit=prop.unit if capability in {"number", "measurement"} else "",
        bounds=_bounds(prop) if capability == "number" else (),
        options=prop.options if prop.datatype == "enum" else (),
    )


def add_press(part: BytesPart, prop: HomieProperty) -> None:
    """Add ``press``: the options of an enum, or a true boolean."""

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        if isinstance(value, bool):
            return {"press": "single"} if value else NO_READINGS
        return {"press": value} if isinstance(value, str) else NO_READINGS

    part.read_events_from(prop.topic, read)
    part.add_capability("press", options=("single",) if prop.datatype == "boolean" else prop.options)


def add_flag(part: BytesPart, prop: HomieProperty) -> None:
    """Add ``on_off`` with the value of *prop*."""
    _add(
        part,
        "on_off",
        prop,
        lambda value: value if isinstance(value, bool) else None,
        lambda value: "true" if require_bool("on_off", value) else "false",
        readable=prop.is_retained,
    )


def add_percent(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Add *capability* in percent of the range of *prop*."""
    _add(
        part,
        capability,
        prop,
        lambda value: _percent(prop, value),
        lambda value: _spell_percent(prop, capability, require_number(capability, value, 0, _PERCENT, "%")),
        readable=prop.is_retained,
    )


def add_temperature(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Add *capability* in degrees Celsius."""
    is_fahrenheit = prop.unit.strip() in _FAHRENHEIT
    ends = _bounds(prop)
    bounds = celsius_bounds(*ends) if ends and is_fahrenheit else ends

    def celsius_of(value: PlainValue) -> PlainValue:
        if not isinstance(value, float):
            return None
        return to_celsius(value, _DIGITS) if is_fahrenheit else value

    def spell(value: PlainValue) -> str:
        celsius = require_number(capability, value, *(bounds or _ANY_CELSIUS), "°C")
        number = to_fahrenheit(celsius, _DIGITS) if is_fahrenheit else celsius
        return spell_plain(prop, capability, prop.range.kept(number) if bounds else number)

    _add(part, capability, prop, celsius_of, spell, readable=True, bounds=bounds if prop.is_settable else ())


def add_enum(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    """Add *capability* with the options of *prop*, in small letters."""
    options = {option.casefold(): option for option in prop.options}
    _add(
        part,
        capability,
        prop,
        lambda value: value.casefold() if isinstance(value, str) else None,
        lambda value: options[require_option(capability, value, options)],
        readable=prop.is_retained,
        options=tuple(options),
    )


def _add(
    part: BytesPart,
    capability: str,
    prop: HomieProperty,
    meaning: Callable[[PlainValue], PlainValue],
    spell: Callable[[PlainValue], str],
    *,
    readable: bool,
    bounds: tuple[float, ...] = (),
    unit: str = "",
    options: tuple[str, ...] = (),
) -> None:
    """Add *capability*; *meaning* translates reported values, None for none, and *spell* commanded ones."""

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        found = None if value is None else meaning(value)
        return {capability: found} if found is not None or is_unknown_number(prop, payload) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> Publications:
        return (publication(prop, spell(value)),)

    if prop.is_retained:
        part.read_from(prop.topic, read)
    elif not prop.is_settable:
        part.read_events_from(prop.topic, read)
    if prop.is_settable:
        part.add_command_topics(f"{prop.topic}/set")
    writer = write if prop.is_settable else None
    part.add_capability(capability, readable=readable, writer=writer, unit=unit, bounds=bounds, options=options)


def percent_of(prop: HomieProperty, payload: bytes) -> float | None:
    """Return *payload* of *prop* in percent of its range."""
    return _percent(prop, read_plain(prop, payload))


def percent_written(prop: HomieProperty, capability: str, percent: float) -> Publication:
    """Return the command that sets *prop* to *percent* of its range, at least to its smallest value."""
    return publication(prop, _spell_percent(prop, capability, percent))


def _percent(prop: HomieProperty, value: PlainValue) -> float | None:
    if not isinstance(value, float):
        return None
    least, most = _ends(prop)
    percent = round((value - least) * _PERCENT / (most - least), 6)
    return percent if 0 <= percent <= _PERCENT else None


def _spell_percent(prop: HomieProperty, capability: str, percent: float) -> str:
    least, most = _ends(prop)
    value = least + (most - least) * percent / _PERCENT
    return spell_plain(prop, capability, value if prop.range.least is None else max(value, prop.range.least))


def _ends(prop: HomieProperty) -> tuple[float, float]:
    """Return the numbers for 0 % and 100 %. A range from 1 leaves out the 0, which means off."""
    least = prop.range.least or 0.0
    most = _PERCENT if prop.range.most is None else prop.range.most
    if least == 1.0 and most > 1.0:
        least = 0.0
    return (least, most) if most > least else (0.0, _PERCENT)


def _bounds(prop: HomieProperty) -> tuple[float, float] | tuple[()]:
    least, most = prop.range.least, prop.range.most
    return (least, most) if least is not None and most is not None else ()
