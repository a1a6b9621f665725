"""Codec of a part of a thing, and its values as the data schemas say. Pure."""

from __future__ import annotations

import colorsys
import json
import math
import re
from functools import partial

from homebot.conventions.command_values import Writer
from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import (
    MAX_STATE_BYTES,
    NO_READINGS,
    Readings,
    clean_text,
    is_unknown,
    parse_json,
    shown,
)
from homebot.conventions.table_codec import Reader, TableCodec, raw_bytes
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.numbers import to_number
from homebot.wot import (
    TEXT_CONTENT_TYPE,
    Affordance,
    ClassifiedPart,
    Form,
    canonical,
    observe_form,
    on_the_wire,
    write_form,
)

__all__ = ["is_supported", "thing_codec"]


_JSON = re.compile(r"application/([a-z0-9.+-]+\+)?json")
_TRUE = frozenset({"true", "on", "1", "yes", "open", "locked", "active"})
_FALSE = frozenset({"false", "off", "0", "no", "closed", "unlocked", "inactive"})
_RGB = re.compile(r"#([0-9a-fA-F]{6})")
_LOCKS = {True: "locked", False: "unlocked"}
_MAX_TEXT = 500


def is_supported(content_type: str) -> bool:
    """Return whether payloads of this type are understood: JSON and plain text."""
    kind = content_type.partition(";")[0].strip().casefold()
    return kind == TEXT_CONTENT_TYPE or _JSON.fullmatch(kind) is not None


def _decode_value(capability: Capability, affordance: Affordance, payload: bytes) -> tuple[PlainValue] | None:
    """Return the value of *payload*, in a tuple because it may be None, unknown; None where it has none."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        value: object = parse_json(payload)
    except WireError:
        value = payload.decode(errors="replace").strip()  # bare words, whatever the content type says
    if value is None or (CAPABILITIES[capability.name].kind == "number" and is_unknown(value)):
        return (None,)
    found = _decode(capability, affordance, value)
    return None if found is None else (found,)


def _encode_value(capability: Capability, affordance: Affordance, value: PlainValue, content_type: str) -> bytes:
    """Return the payload that makes *capability* become *value*.

    Raises:
        RefusedError: It is no value of this capability.
    """
    encoded = _encode(capability, affordance, value)
    if content_type.partition(";")[0].strip().casefold() == TEXT_CONTENT_TYPE and isinstance(encoded, str):
        return encoded.encode(errors="replace")
    return json.dumps(encoded, ensure_ascii=False).encode(errors="replace")


def _decode(capability: Capability, affordance: Affordance, value: object) -> PlainValue:
    name = capability.name
    kind = CAPABILITIES[name].kind
    if name == "color":
        return _color(value)
    if name == "lock" and not (isinstance(value, str) and value.casefold() in CAPABILITIES[name].options):
        flag = _flag(affordance, value)
        return None if flag is None else _LOCKS[flag]
    if kind == "bool":
        return _flag(affordance, value)
    if kind == "number":
        number = to_number(value)
        return None if number is None else canonical(name, affordance, number)
    if isinstance(value, str):
        return clean_text(value.casefold() if name == "lock" else value, _MAX_TEXT)
    return clean_text(json.dumps(value, ensure_ascii=False), _MAX_TEXT)


def _encode(capability: Capability, affordance: Affordance, value: PlainValue) -> object:
    name, what = capability.name, f"{capability.name} {shown(value)}"
    kind = CAPABILITIES[name].kind
    if name == "color":
        return _encode_color(what, value)
    if name == "lock":
        if value not in {"locked", "unlocked"}:
            raise RefusedError(what, "it takes locked, unlocked")
        return _encode_flag(affordance, value == "locked") if affordance.schema.type == "boolean" else value
    if kind == "bool":
        if not isinstance(value, bool):
            raise RefusedError(what, "it takes true or false")
        return _encode_flag(affordance, value)
    if kind == "number":
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise RefusedError(what, "it takes a number")
        bounds = capability.bounds or CAPABILITIES[name].bounds
        if bounds and not bounds[0] <= value <= bounds[-1]:
            raise RefusedError(what, f"it takes {bounds[0]:g} to {bounds[-1]:g}")
        number = on_the_wire(name, affordance, value)
        if not math.isfinite(number):
            raise RefusedError(what, "it takes a number that its format can express")
        return int(number) if number.is_integer() else number
    if not isinstance(value, str) or (capability.options and value not in capability.options):
        raise RefusedError(what, f"it takes {', '.join(capability.options[:20])}" if capability.options else "a text")
    return value


def _flag(affordance: Affordance, value: object) -> bool | None:
    """Return a flag; of two listed texts, the one that means yes, or else the second, is true."""
    if isinstance(value, bool):
        return value
    enum = affordance.schema.enum
    if len(enum) == 2 and value in enum:  # a yes and a no
        return value == _values_by_flag(affordance)[True]
    text = str(value).casefold() if isinstance(value, (str, int, float)) else ""
    return True if text in _TRUE else False if text in _FALSE else None


def _encode_flag(affordance: Affordance, value: bool) -> object:  # noqa: FBT001  # what it is about
    if len(affordance.schema.enum) == 2 and affordance.schema.type != "boolean":  # a yes and a no
        return _values_by_flag(affordance)[value]
    if affordance.schema.type == "string":
        return "true" if value else "false"
    return value


def _values_by_flag(affordance: Affordance) -> dict[bool, object]:
    first, second = affordance.schema.enum
    yes = str(first).casefold() in _TRUE or str(second).casefold() in _FALSE
    return {True: first, False: second} if yes else {True: second, False: first}


def _color(value: object) -> tuple[float, float] | None:
    match = _RGB.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return None
    red, green, blue = bytes.fromhex(match[1])
    hue, saturation, _ = colorsys.rgb_to_hsv(red / 255, green / 255, blue / 255)
    return round(hue * 360, 1), round(saturation * 100, 1)


def _encode_color(what: str, value: PlainValue) -> str:
    match value:
        case (int() | float() as hue, int() | float() as saturation) if 0 <= hue <= 360 and 0 <= saturation <= 100:
            rgb = colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1.0)
            return "#" + "".join(f"{round(one * 255):02x}" for one in rgb)
        case _:
            raise RefusedError(what, "it takes hue 0 to 360 and saturation 0 to 100")


def thing_codec(part: ClassifiedPart) -> TableCodec[bytes]:
    """Return the codec of one part of a thing.

    Args:
        part: The part; what it reads and writes follows from its capabilities, whatever its affordances offer.
    """
    readers: dict[str, tuple[Reader[bytes], ...]] = {}
    event_readers: dict[str, tuple[Reader[bytes], ...]] = {}
    writers: dict[str, Writer] = {}
    for capability, affordance in part.affordances:
        observed, written = observe_form(affordance), write_form(affordance)
        if capability.readable and observed is not None:
            readers.setdefault(observed.filter, ())
            table = event_readers if affordance.kind == "event" else readers
            table[observed.filter] = (*table.get(observed.filter, ()), partial(_read, capability, affordance))
        if capability.settable and written is not None:
            writers.setdefault(capability.name, partial(_write, capability, affordance, written))
    return TableCodec(raw_bytes, readers, event_readers, writers)


def _read(capability: Capability, affordance: Affordance, payload: bytes) -> Readings:
    value = _decode_value(capability, affordance, payload)
    return NO_READINGS if value is None else {capability.name: value[0]}


def _write(
    capability: Capability, affordance: Affordance, form: Form, value: PlainValue, _transition: float
) -> Publications:
    """Write a value; a Thing Description has no transitions."""
    if affordance.kind == "action":
        if value is not True:
            raise RefusedError(f"{capability.name} {shown(value)}", "it takes only true")
        return (Publication(form.topic, b"", form.qos, form.retain),)
    payload = _encode_value(capability, affordance, value, form.content_type)
    return (Publication(form.topic, payload, form.qos, form.retain),)
