"""Values of properties, as Homie spells them and in plain Python. Pure.

A number is a ``float``, a colour is hue in degrees, saturation and brightness in percent (None where it has none).

Source: Homie convention 5, Payload; Homie 4.0, Payload.
"""

import colorsys
import math
import re

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import Publication
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.payload import clean_text, is_unknown, shown, to_text
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homie.formats.model import COLOR_FORMS, HomieProperty
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
