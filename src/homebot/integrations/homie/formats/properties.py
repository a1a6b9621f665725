"""Capabilities of single properties: the codec of their values, by capability. Pure.

A number is a ``float``, a colour is hue in degrees, saturation and brightness in percent (None where it has none).

Source: Homie convention 5 and 4.0, Payload.
"""

import colorsys
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Unpack

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.description import Publication, Publications
from homebot.conventions.light_color import MIRED, from_hue_saturation, nearest_mired_bounds, to_hue_saturation
from homebot.conventions.part_builder import BytesPart, PartFields
from homebot.conventions.payload import Readings, clean_text, is_unknown, shown, to_text, unreadable
from homebot.conventions.units import Conversion, celsius_bounds, conversion_of, number_grid, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homie.formats.model import COLOR_FORMS, HomieNode, HomieProperty
from homebot.support.numbers import to_number

_EMPTY_STRING = "\0"
_INTEGER = re.compile(r"-?[0-9]{1,19}")
_FLOAT = re.compile(r"-?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NUMBERS = frozenset({"integer", "float"})
_MAX_TEXT_CHARACTERS = 255
_MAX_NUMBER = 1e15
_EXACT_QOS = 2
_ANY_WHITE = (2000, 6500)
_LIMITS = {"hsv": (360.0, 100.0, 100.0), "rgb": (255.0, 255.0, 255.0), "xyz": (1.0, 1.0)}


def read_plain(prop: HomieProperty, payload: bytes) -> PlainValue:
    """Return the value of *payload*; None if it is invalid for *prop*. A colour is not plain."""
    text = to_text(payload)
    if text is None:
        return None
    match prop.datatype:
        case "boolean":
            return {prop.flags[0]: False, prop.flags[1]: True}.get(text)
        case "integer" | "float":
            pattern = _INTEGER if prop.datatype == "integer" else _FLOAT
            number = to_number(text) if pattern.fullmatch(text) else None
            return number if number is not None and prop.range.holds(number) else None
        case "enum":
            return text if text in prop.options else None
        case "color":
            return None
        case _:
            return clean_text(text, _MAX_TEXT_CHARACTERS) if text else None


def is_unknown_number(prop: HomieProperty, payload: bytes) -> bool:
    """Return whether *payload* is the unknown value of a number."""
    text = to_text(payload) if prop.datatype in _NUMBERS else None
    return text is not None and is_unknown(text)


def spell_plain(prop: HomieProperty, capability: str, value: PlainValue) -> str:
    """Return *value* as the payload of a command to *prop*.

    Raises:
        RefusedError: The value is invalid.
    """
    match prop.datatype:
        case "boolean":
            return prop.flags[require_bool(capability, value)]
        case "integer" | "float":
            least = -_MAX_NUMBER if prop.range.least is None else prop.range.least
            most = _MAX_NUMBER if prop.range.most is None else prop.range.most
            number = prop.range.nearest(require_number(capability, value, least, most, prop.unit))
            if prop.datatype == "integer":
                return str(math.floor(number + 0.5))
            return f"{number:.9f}".rstrip("0").rstrip(".") if abs(number) < _MAX_NUMBER else repr(number)
        case "enum":
            return require_option(capability, value, prop.options)
        case _:
            if not isinstance(value, str) or len(value) > _MAX_TEXT_CHARACTERS or not value.isprintable():
                raise RefusedError(f"{capability} {shown(value)}", f"it takes a text of at most {_MAX_TEXT_CHARACTERS}")
            return value or _EMPTY_STRING


def read_color(prop: HomieProperty, payload: bytes) -> tuple[float, float, float | None] | None:
    """Return hue, saturation and brightness in *payload*; None if it is no colour of *prop*."""
    text = to_text(payload)
    if text is None or len(text) > _MAX_TEXT_CHARACTERS:
        return None
    fields = text.split(",")
    form = fields.pop(0) if prop.names_form else (*prop.options, "")[0]
    limits = _LIMITS.get(form, ()) if form in prop.options else ()
    numbers = tuple(number for number in map(to_number, fields) if number is not None)
    if not numbers or not len(fields) == len(numbers) == len(limits):
        return None
    if not all(0 <= number <= most for number, most in zip(numbers, limits, strict=True)):
        return None
    if form == "hsv":
        return numbers[0], numbers[1], numbers[2]
    if form == "rgb":
        hue, saturation, brightness = colorsys.rgb_to_hsv(*(number / 255 for number in numbers))
        return round(hue * 360, 3), round(saturation * 100, 3), round(brightness * 100, 3)
    return *to_hue_saturation("xy", numbers, _ANY_WHITE), None


def read_hue_saturation(prop: HomieProperty, payload: bytes) -> tuple[float, float] | None:
    """Return hue and saturation of :func:`read_color`."""
    color = read_color(prop, payload)
    return None if color is None else color[:2]


def spell_color(prop: HomieProperty, hue: float, saturation: float) -> str:
    """Return a colour at full brightness as the payload of a command to *prop*."""
    form = next((form for form in COLOR_FORMS if form in prop.options), "rgb")
    if form == "hsv":
        numbers: tuple[float, ...] = (round(hue), round(saturation), 100)
    elif form == "rgb":
        numbers = from_hue_saturation("rgb", hue, saturation, _ANY_WHITE)
    else:
        numbers = from_hue_saturation("xy", hue, saturation, _ANY_WHITE)
    fields = [f"{number:g}" for number in numbers]
    return ",".join([form, *fields] if prop.names_form else fields)


def publication(prop: HomieProperty, text: str) -> Publication:
    """Return the command that sets *prop*: never retained, and exactly once where it is a state."""
    return Publication(f"{prop.topic}/set", text.encode(), _EXACT_QOS if prop.is_retained else 0)


_FAHRENHEIT = frozenset({"F", "°F"})
_OPENINGS = ("open", "closed")
_PERCENT = 100.0
_ANY_CELSIUS = (-273.15, 1e6)
_ANY_KELVIN = (1000.0, 40_000.0)
_DIGITS = 3


@dataclass(frozen=True, slots=True)
class _ValueCodec:
    """The codec of a capability: the meaning of a property's value, None for no value, and the text of a command."""

    meaning: Callable[[PlainValue], PlainValue]
    spell: Callable[[PlainValue], str]
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()
    grid: tuple[float, ...] = ()
    is_always_readable: bool = False
    read: Callable[[HomieProperty, bytes], PlainValue] = read_plain


def add_property(
    part: BytesPart, capability: str, prop: HomieProperty, *, on: Publications = (), off: Publications = ()
) -> None:
    """Add *capability* with the value of *prop*; *on* is sent after each command, and *off*, if any, in place of 0."""
    if capability == "press":
        _add_press(part, prop)
        return
    codec = _CODECS.get(capability, _plain_codec)(capability, prop)

    def read(payload: bytes) -> Readings:
        value = codec.meaning(codec.read(prop, payload))
        if value is not None or is_unknown_number(prop, payload):
            return {capability: value}
        return unreadable(payload, _expected(prop))

    def write(value: PlainValue, _transition: float) -> Publications:
        if off and value == 0 and value is not False:
            return off
        return (publication(prop, codec.spell(value)), *on)

    if prop.is_retained:
        part.read_from(prop.topic, read)
    elif not prop.is_settable:
        part.read_events_from(prop.topic, read)
    if prop.is_settable:
        part.add_command_topics(f"{prop.topic}/set")
    part.add_capability(
        capability,
        readable=prop.is_retained or codec.is_always_readable,
        writer=write if prop.is_settable else None,
        unit=codec.unit,
        bounds=codec.bounds,
        options=codec.options,
        grid=codec.grid,
    )


def _expected(prop: HomieProperty) -> str | tuple[str, ...]:
    """Return what *prop* announces: its words, or its datatype and format."""
    words = prop.flags if prop.datatype == "boolean" else prop.options if prop.datatype == "enum" else ()
    return words or f"{prop.datatype} as announced"


def add_properties(part: BytesPart, props: Mapping[str, HomieProperty], *capabilities: str) -> None:
    """Add those *capabilities* that have a property."""
    for capability in capabilities:
        if capability in props:
            add_property(part, capability, props[capability])


def _add_press(part: BytesPart, prop: HomieProperty) -> None:
    """Add the options of an enum, or a true boolean, as events."""

    def read(payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        press = "single" if value is True else value
        return {"press": press} if isinstance(press, str) else unreadable(payload, _expected(prop))

    part.read_events_from(prop.topic, read)
    part.add_capability("press", options=("single",) if prop.datatype == "boolean" else prop.options)


def _plain_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    conversion = conversion_of(capability, prop.unit) or Conversion()
    return _ValueCodec(
        lambda value: conversion.value(value * prop.sign) if isinstance(value, float) else value,
        lambda value: spell_plain(prop, capability, value),
        unit=prop.unit if capability in {"number", "measurement"} else "",
        bounds=_bounds(prop) if capability == "number" else (),
        options=prop.options if prop.datatype == "enum" else (),
        grid=prop.range.grid if prop.is_settable else (),
        is_always_readable=not prop.is_settable,
    )


def _flag_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    return _ValueCodec(
        lambda value: value if isinstance(value, bool) else None,
        lambda value: prop.flags[require_bool(capability, value)],
    )


def _valve_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    states = {False: "closed", True: "open"}
    return _ValueCodec(
        lambda value: states[value] if isinstance(value, bool) else None,
        lambda value: prop.flags[require_option(capability, value, _OPENINGS) == "open"],
        options=_OPENINGS,
    )


def _enum_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    options = {option.casefold(): option for option in prop.options}
    return _ValueCodec(
        lambda value: value.casefold() if isinstance(value, str) else None,
        lambda value: options[require_option(capability, value, options)],
        options=tuple(options),
    )


def _percent_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    least, most = _ends(prop)
    return _ValueCodec(
        lambda value: percent_of(prop, value),
        lambda value: _spell_percent(prop, capability, require_number(capability, value, 0, _PERCENT, "%")),
        grid=tuple(
            [
                (end - shift) * _PERCENT / (most - least)
                for end, shift in zip(prop.range.grid, (least, 0.0), strict=False)
            ]
        ),
    )


def _temperature_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    is_fahrenheit = prop.unit.strip() in _FAHRENHEIT
    ends = _bounds(prop)
    bounds = celsius_bounds(*ends) if ends and is_fahrenheit else ends
    grid = number_grid(prop.range.least, prop.range.step, is_fahrenheit=is_fahrenheit)

    def meaning(value: PlainValue) -> PlainValue:
        if not isinstance(value, float):
            return None
        return to_celsius(value, _DIGITS) if is_fahrenheit else value

    def spell(value: PlainValue) -> str:
        celsius = require_number(capability, value, *(bounds or _ANY_CELSIUS), "°C")
        number = to_fahrenheit(celsius, _DIGITS) if is_fahrenheit else celsius
        return spell_plain(prop, capability, prop.range.kept(number) if bounds else number)

    return _ValueCodec(meaning, spell, bounds=bounds if prop.is_settable else (), grid=grid, is_always_readable=True)


def _color_codec(_capability: str, prop: HomieProperty) -> _ValueCodec:
    return _ValueCodec(
        lambda value: value, lambda value: spell_color(prop, *require_color(value)), read=read_hue_saturation
    )


def _white_codec(capability: str, prop: HomieProperty) -> _ValueCodec:
    least, most = prop.range.least, prop.range.most
    is_kelvin = prop.unit.strip() == "K" or (most is not None and most > _ANY_KELVIN[0])
    bounds: tuple[float, ...] = ()
    if least is not None and most is not None and 1 <= least < most:
        bounds = (least, most) if is_kelvin else nearest_mired_bounds(least, most)
    digits = 0 if prop.datatype == "integer" else _DIGITS

    def meaning(value: PlainValue) -> PlainValue:
        if not isinstance(value, float) or value <= 0:
            return None
        return value if is_kelvin else float(round(MIRED / value))

    def spell(value: PlainValue) -> str:
        low, high = bounds or _ANY_KELVIN
        kelvin = require_number(capability, value, low, high, "K")
        return spell_plain(prop, capability, prop.range.kept(round(kelvin if is_kelvin else MIRED / kelvin, digits)))

    return _ValueCodec(meaning, spell, bounds=bounds, grid=prop.range.grid if is_kelvin else ())


_CODECS: Mapping[str, Callable[[str, HomieProperty], _ValueCodec]] = {
    **dict.fromkeys(("level", "position", "tilt", "fan_speed"), _percent_codec),
    **dict.fromkeys(("heating_setpoint", "cooling_setpoint", "local_temperature", "temperature"), _temperature_codec),
    **dict.fromkeys(("thermostat_mode", "fan_mode"), _enum_codec),
    "on_off": _flag_codec,
    "valve": _valve_codec,
    "color": _color_codec,
    "color_temperature": _white_codec,
}
"""Codecs of capabilities that are not plain values."""


def percent_of(prop: HomieProperty, value: PlainValue) -> float | None:
    """Return the number *value* of *prop* in percent of its range; None for another value."""
    if not isinstance(value, float):
        return None
    least, most = _ends(prop)
    percent = round((value - least) * _PERCENT / (most - least), 6)
    return percent if 0 <= percent <= _PERCENT else None


def percent_written(prop: HomieProperty, capability: str, percent: float) -> Publication:
    """Return the command that sets *prop* to *percent* of its range, at least to its smallest value."""
    return publication(prop, _spell_percent(prop, capability, percent))


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


def node_part(node: HomieNode, service_type: str, *, suffix: str = "", **fields: Unpack[PartFields]) -> BytesPart:
    """Return a part of *node* without capabilities; its *suffix* is empty for the main part of the node."""
    fields["name"] = " ".join(dict.fromkeys(filter(None, (node.name, fields.get("name")))))
    fields["advertised"] = node.type
    return BytesPart("/".join(filter(None, (node.id, suffix))), service_type, **fields)
