"""The payloads of things: their formats, and their values by data schema. Pure.

A *document* is the value in a payload: null, a boolean, a number, a text, a list or an object.
"""

import colorsys
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.conventions.payload import MAX_STATE_BYTES, clean_text, is_unknown, parse_json, shown
from homebot.conventions.units import Conversion, celsius_bounds, conversion_of, to_celsius, to_fahrenheit
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability
from homebot.devices.text.states import is_share
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.things.formats.thing import Affordance, DataSchema
from homebot.integrations.things.formats.vocabulary import UNITS
from homebot.support.numbers import to_number

_SEPARATORS = str.maketrans("", "", " _-")


def unit_of(schema: DataSchema) -> str:
    """Return the unit of a schema in the vocabulary's spelling: ``celsius`` and ``unit:DegreeCelsius`` are ``°C``."""
    bare = schema.unit.rpartition("/")[2].rpartition(":")[2] if ":" in schema.unit else schema.unit
    return UNITS.get(bare.casefold().translate(_SEPARATORS), bare)


_PERCENT = 100.0
_EXACT = 12
_MAX_UNIT_CHARACTERS = 40
_NO_RANGE = 1e15
"""Range from which bounds are those of a number type, not of a device."""


def canonical(capability: str, affordance: Affordance, number: float) -> float | None:
    """Return the thing's *number* in the vocabulary's unit; None if it is meaningless."""
    if "capability" in affordance.extension:  # homebot's own terms are already canonical
        return number
    if (ends := _ends(capability, affordance)) is not None:
        low, high = ends
        return min(max((number - low) / (high - low) * _PERCENT, 0.0), _PERCENT)
    if _is_mired(capability, affordance):
        return float(round(MIRED / number)) if number >= 1 else None
    if _is_fahrenheit(capability, affordance):
        return to_celsius(number)
    return _conversion(capability, affordance).value(number)


def bounds_of(capability: str, affordance: Affordance) -> tuple[float, ...]:
    """Return the smallest and largest allowed number, in the vocabulary's unit; empty unless both are known.

    They apply to values after the thing's own rounding, so that a rounded bound is allowed.
    """
    low, high = affordance.schema.minimum, affordance.schema.maximum
    if low is None or high is None:
        return ()
    is_own = "capability" in affordance.extension
    if not is_own and _is_mired(capability, affordance) and low >= 1:
        return nearest_mired_bounds(low, high)
    ends = [value for end in (low, high) if (value := canonical(capability, affordance, end)) is not None]
    if len(ends) < 2:  # one of them is meaningless
        return ()
    if not is_own and _is_fahrenheit(capability, affordance):
        return celsius_bounds(min(low, high), max(low, high))
    return min(ends), max(ends)


def on_the_wire(capability: str, affordance: Affordance, number: float) -> float:
    """Return *number*, given in the vocabulary's unit, as the thing's; not finite if impossible."""
    if "capability" in affordance.extension:
        return number
    if (ends := _ends(capability, affordance)) is not None:
        low, high = ends
        value = low + number / _PERCENT * (high - low)
    elif _is_mired(capability, affordance):
        value = MIRED / number if number >= 1 else math.nan
    elif _is_fahrenheit(capability, affordance):
        value = to_fahrenheit(number, _EXACT)
    else:
        conversion = _conversion(capability, affordance)
        value = number * conversion.over / conversion.times + conversion.shift
    if not math.isfinite(value):
        return value
    least, most = affordance.schema.minimum, affordance.schema.maximum
    if affordance.schema.type != "integer":
        return _within(round(value, 6), least, most)
    least, most = None if least is None else math.ceil(least), None if most is None else math.floor(most)
    return _within(float(round(value)), least, most)


def _within(number: float, low: float | None, high: float | None) -> float:
    """Clamp *number*, which may exceed the bounds by rounding."""
    number = number if low is None else max(number, float(low))
    return number if high is None else min(number, float(high))


def _ends(capability: str, affordance: Affordance) -> tuple[float, float] | None:
    low, high = affordance.schema.minimum, affordance.schema.maximum
    if low is None or high is None or not 0 < high - low < _NO_RANGE:
        return None
    is_fraction = is_share(capability) or (high == 1 and CAPABILITIES[capability].bounds == (0.0, _PERCENT))
    return (low, high) if is_fraction else None


def _is_mired(capability: str, affordance: Affordance) -> bool:
    return capability == "color_temperature" and unit_of(affordance.schema) == "mired"


def _is_fahrenheit(capability: str, affordance: Affordance) -> bool:
    return CAPABILITIES[capability].unit == "°C" and unit_of(affordance.schema) == "°F"


def _conversion(capability: str, affordance: Affordance) -> Conversion:
    unit = unit_of(affordance.schema)
    measured = "temperature" if CAPABILITIES[capability].unit == "°C" else capability
    return (conversion_of(measured, unit[:_MAX_UNIT_CHARACTERS]) if unit else None) or Conversion()


TEXT_CONTENT_TYPE = "text/plain"

_JSON = re.compile(r"application/([a-z0-9.+-]+\+)?json")
_TRUE = frozenset({"true", "on", "1", "yes", "open", "locked", "active"})
_FALSE = frozenset({"false", "off", "0", "no", "closed", "unlocked", "inactive"})
_RGB = re.compile(r"#([0-9a-fA-F]{6})")
_LOCKS = {True: "locked", False: "unlocked"}
_MAX_TEXT = 500
_FULL = 255


@dataclass(frozen=True, slots=True)
class PayloadFormat:
    """A payload format: *parse* returns the document or raises WireError, *encode* returns the payload."""

    parse: Callable[[bytes], object]
    encode: Callable[[object], bytes]


PayloadFormats: TypeAlias = Callable[[str], PayloadFormat | None]
"""Returns the format of a content type; None if it is not supported."""


def _parse_words(payload: bytes) -> object:
    """Parse JSON, or bare words, which many devices send with any content type."""
    if len(payload) > MAX_STATE_BYTES:
        raise WireError(f"a payload of {len(payload)} bytes is longer than {MAX_STATE_BYTES}")
    try:
        return parse_json(payload, lenient=True)
    except WireError:
        return payload.decode(errors="replace").strip()


def _as_json(document: object) -> bytes:
    return json.dumps(document, ensure_ascii=False).encode(errors="replace")


def _as_words(document: object) -> bytes:
    """Return plain text; numbers and booleans as in JSON."""
    return document.encode(errors="replace") if isinstance(document, str) else _as_json(document)


_JSON_OR_WORDS = PayloadFormat(_parse_words, _as_json)
_WORDS = PayloadFormat(_parse_words, _as_words)


def basic_formats(content_type: str) -> PayloadFormat | None:
    """Return the format of JSON or plain text, if *content_type* is one of them."""
    kind = media_type(content_type)
    if kind == TEXT_CONTENT_TYPE:
        return _WORDS
    return _JSON_OR_WORDS if _JSON.fullmatch(kind) else None


def media_type(content_type: str) -> str:
    """Return a content type in lower case, without parameters."""
    return content_type.partition(";")[0].strip().casefold()


def decode_document(capability: Capability, affordance: Affordance, document: object) -> tuple[PlainValue] | None:
    """Return the value of *capability* in *document*, in the vocabulary's unit.

    Returns:
        The value, in a tuple because it may be None for unknown; None if it is meaningless.
    """
    schema = affordance.schema
    if affordance.kind == "event" and document in (None, ""):
        return (affordance.name,)  # an event without data
    if isinstance(document, dict) and schema.member and schema.member not in document:
        return None
    if isinstance(document, dict) and schema.member:
        document = document[schema.member]
    elif isinstance(document, dict) and affordance.name in document and schema.type not in {"", "object"}:
        document = document[affordance.name]  # as WebThings answer: {"on": true}
    if document is None or _is_no_number(capability, schema, document):
        return (None,)
    value_found = _decode(capability, affordance, document)
    return None if value_found is None else (value_found,)


def _is_no_number(capability: Capability, schema: DataSchema, document: object) -> bool:
    """Return whether *document* represents an unknown number."""
    is_number = CAPABILITIES[capability.name].kind == "number"
    return is_number and (is_unknown(document) or document in schema.words)


def encode_document(capability: Capability, affordance: Affordance, value: PlainValue) -> object:
    """Return the document that sets *capability* to *value*; raise RefusedError if that is impossible."""
    document = _encode(capability, affordance, value)
    return {affordance.schema.member: document} if affordance.schema.member else document


def _encode(capability: Capability, affordance: Affordance, value: PlainValue) -> object:
    name = capability.name
    if name == "color":
        hue, saturation = require_color(value)
        rgb = [round(share * _FULL) for share in colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1.0)]
        return dict(zip("rgb", rgb, strict=True)) if is_rgb(affordance.schema) else f"#{bytes(rgb).hex()}"
    if name == "lock":
        state = require_option(name, value, _LOCKS.values())
        if affordance.schema.type == "boolean":
            return _encode_flag(affordance, state == "locked")
        return next((option for option in affordance.schema.enum if str(option).casefold() == state), state)
    kind = CAPABILITIES[name].kind
    if kind == "bool":
        return _encode_flag(affordance, require_bool(name, value))
    if kind == "number":
        return _encode_number(capability, affordance, value)
    if capability.options:
        return require_option(name, value, capability.options)
    if not isinstance(value, str):
        raise RefusedError(f"{name} {shown(value)}", "it takes a text")
    return value


def _encode_number(capability: Capability, affordance: Affordance, value: PlainValue) -> object:
    name = capability.name
    bounds = capability.bounds or CAPABILITIES[name].bounds or (-math.inf, math.inf)
    number = require_number(name, value, bounds[0], bounds[-1])
    least = affordance.schema.minimum or 0
    if name == "level" and number == 0 and least > 0:  # otherwise 0 % would be rounded up, and the lamp stay on
        problem = f"its {affordance.name[:60]} is never below {least:g}, and it has no switch"
        raise RefusedError(f"{name} {shown(value)}", problem)
    number = on_the_wire(name, affordance, number)
    if not math.isfinite(number):
        raise RefusedError(f"{name} {shown(value)}", "it takes a number that its format can express")
    return int(number) if number.is_integer() else number


def _decode(capability: Capability, affordance: Affordance, value: object) -> PlainValue:
    name = capability.name
    kind = CAPABILITIES[name].kind
    if name == "color":
        return _color(value)
    if name == "lock":
        if isinstance(value, str) and value.casefold() in CAPABILITIES["lock"].options:
            return clean_text(value.casefold(), _MAX_TEXT)
        flag = _flag(affordance, value)
        return None if flag is None else _LOCKS[flag]
    if kind == "bool":
        return _flag(affordance, value)
    if kind == "number":
        number = to_number(value)
        return None if number is None else canonical(name, affordance, number)
    return clean_text(value if isinstance(value, str) else json.dumps(value, ensure_ascii=False), _MAX_TEXT)


def _flag(affordance: Affordance, value: object) -> bool | None:
    """Return a flag; of two listed texts, the one meaning yes, or else the second, is true."""
    if isinstance(value, bool):
        return value
    enum = affordance.schema.enum
    if len(enum) == 2 and value in enum:  # a yes and a no
        return value == _values_by_flag(affordance)[True]
    text = str(value).casefold() if isinstance(value, (str, int, float)) else ""
    return True if text in _TRUE else False if text in _FALSE else None


def _encode_flag(affordance: Affordance, value: bool) -> object:  # noqa: FBT001 - the value itself
    if len(affordance.schema.enum) == 2 and affordance.schema.type != "boolean":  # a yes and a no
        return _values_by_flag(affordance)[value]
    if affordance.schema.type == "string":
        return "true" if value else "false"
    return value


def _values_by_flag(affordance: Affordance) -> dict[bool, object]:
    first, second = affordance.schema.enum
    yes = str(first).casefold() in _TRUE or str(second).casefold() in _FALSE
    return {True: first, False: second} if yes else {True: second, False: first}


def is_rgb(schema: DataSchema) -> bool:
    """Return whether values are objects of exactly red, green and blue, from 0 to 255 each."""
    channels = dict(schema.members)
    return channels.keys() == {"r", "g", "b"} and all(channel.maximum in (None, _FULL) for channel in channels.values())


def _color(value: object) -> tuple[float, float] | None:
    channels: list[float | None] = []
    if isinstance(value, str) and (match := _RGB.fullmatch(value)):
        channels += bytes.fromhex(match[1])
    elif isinstance(value, dict):
        channels += [to_number(value.get(letter)) for letter in "rgb"]
    levels = [channel / _FULL for channel in channels if channel is not None and 0 <= channel <= _FULL]
    if len(levels) != 3:
        return None
    hue, saturation, _ = colorsys.rgb_to_hsv(*levels)
    return round(hue * 360, 1), round(saturation * 100, 1)
