"""Payloads of devices: bounded JSON and texts, and the readings taken from them. Pure."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from functools import lru_cache
from types import MappingProxyType
from typing import NoReturn, TypeAlias, TypeVar

from pydantic_core import from_json

from homebot.devices.text.states import means_unknown
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.numbers import to_number
from homebot.strict_json import duplicate_key_hook

__all__ = [
    "MAX_ANNOUNCEMENT_BYTES",
    "MAX_DEPTH",
    "MAX_LONG_STATE_BYTES",
    "MAX_STATE_BYTES",
    "NO_READINGS",
    "DuplicateKeys",
    "JsonMessage",
    "Readings",
    "as_fields",
    "check_depth",
    "check_surrogates",
    "clean_text",
    "compact_json",
    "fields_of",
    "is_unknown",
    "json_decoder",
    "meaning_reader",
    "number_of",
    "numbers_of",
    "parse_json",
    "parse_object",
    "percent_of",
    "read_number",
    "record_duplicate",
    "shown",
    "text_of",
    "to_json",
    "to_text",
    "whole_of",
]


MAX_ANNOUNCEMENT_BYTES = 256 * 1024
"""Longest announcement of one device; one with a hundred parts has about 100 kB."""

MAX_STATE_BYTES = 256 * 1024
"""Longest message of a device's state that is looked at."""

MAX_LONG_STATE_BYTES = 1024 * 1024
"""The same on a topic of announcements, whose messages are long: the ``bridge/info`` of a large Zigbee house tells
states as well."""

MAX_DEPTH = 64
"""Levels of lists and objects in JSON."""

_ENDLESS = frozenset((math.inf, -math.inf))
_MAX_SHOWN = 60


def parse_json(payload: bytes | str, limit: int = MAX_STATE_BYTES, *, unique: bool = False) -> object:
    """Return what *payload* says in JSON.

    Of keys that are there twice the last one counts, see :class:`DuplicateKeys`. Numbers are ``int``, or ``float``
    with an end.

    Args:
        payload: UTF-8 where it is bytes.
        limit: Longest length, in bytes or characters.
        unique: Whether a key that is there twice is an error.

    Raises:
        WireError: It is too long, no JSON as RFC 8259 has it (no NaN, no Infinity), nested deeper than 64 levels, or
            contains half of a surrogate pair.
    """
    if len(payload) > limit:
        raise WireError(f"a payload of {len(payload)} bytes is longer than {limit}")
    if not unique and _noted.get() is None:
        try:
            value: object = from_json(payload, allow_inf_nan=False, cache_strings="keys")
        except ValueError:
            pass  # what it does not take is refused below, with the reason
        else:
            if _is_flat_and_finite(value) or _is_finite(value, MAX_DEPTH):
                return value
    return _parse_slowly(payload, unique=unique)


def _parse_slowly(payload: bytes | str, *, unique: bool) -> object:
    """Return what *payload* says, or the reason why it is no JSON; notes keys that are there twice."""
    try:
        text = payload.decode() if isinstance(payload, bytes) else payload
        decoder = _UNIQUE if unique else _DECODER if _noted.get() is None else _NOTING
        value, end = decoder.raw_decode(text) if text.startswith("{") else (None, -1)
        if end != len(text):  # spaces around it, which nearly no payload has, or no object
            value = decoder.decode(text)
    except RecursionError:
        raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels") from None
    except ValueError as error:
        raise WireError(f"{shown(payload)} is not JSON: {error}") from None
    if text.count("[") + text.count("{") > MAX_DEPTH:
        check_depth(value)
    if "\\u" in text:
        check_surrogates(value)
    return value


def _is_flat_and_finite(value: object) -> bool:
    """Return whether *value* is an object of one level, as most payloads are, that :func:`_is_finite` takes."""
    try:
        return isinstance(value, dict) and _ENDLESS.isdisjoint(value.values())
    except TypeError:  # what has a list or an object in it has no hash
        return False


def _is_finite(value: object, depth: int) -> bool:
    """Return whether *value* has at most *depth* levels, and no number without an end, as which ``1e999`` is read."""
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, list):
        return value not in _ENDLESS
    for one in value:
        kind = type(one)
        if kind is float:
            if one in _ENDLESS:
                return False
        elif (kind is dict or kind is list) and (depth <= 1 or not _is_finite(one, depth - 1)):
            return False
    return True


def parse_object(payload: bytes | str, limit: int = MAX_ANNOUNCEMENT_BYTES) -> dict[str, object]:
    """Return the JSON object that *payload* is.

    Raises:
        WireError: As :func:`parse_json`, or it is JSON but no object.
    """
    value = parse_json(payload, limit)
    if not isinstance(value, dict):
        raise WireError(f"{shown(payload)} is not a JSON object")
    return value


def clean_text(text: str, limit: int = 120) -> str:
    """Return *text* fit to be shown on one line: no control characters, no invisible ones, at most *limit* long.

    Markup stays as it is, because it is text; who shows it must escape it.
    """
    if len(text) <= limit and text.isprintable():
        return text.strip()
    kept = "".join(one if one.isprintable() or one in _JOINERS else " " for one in text[: 4 * limit])
    return " ".join(kept.split())[:limit].rstrip()


def text_of(value: object, limit: int = 120) -> str:
    """Return *value* as :func:`clean_text` has it; empty where it is no text."""
    return clean_text(value, limit) if isinstance(value, str) else ""


def shown(value: object) -> str:
    """Return *value* as an error message may show it: short, on one line."""
    if isinstance(value, (str, bytes)):
        value = value[: _MAX_SHOWN + 1]
        text = repr(value)
    elif isinstance(value, (dict, list)):
        text = f"{type(value).__name__} of {len(value)}"
    else:
        text = f"{value:.6g}" if isinstance(value, float) else type(value).__name__
        if value is None or isinstance(value, bool) or (isinstance(value, int) and abs(value) < _MOST_DIGITS):
            text = str(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"


_JOINERS = "\u200c\u200d"
_MOST_DIGITS = 10**20


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number in JSON")


def _finite(text: str) -> float:
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"{text[:20]} is too large a number")
    return number


_DECODER = json.JSONDecoder(parse_float=_finite, parse_constant=_refuse_constant)


_noted: ContextVar[list[str] | None] = ContextVar("_noted", default=None)
_MOST_NOTED = 10


class DuplicateKeys:
    """A context that gives the keys that were twice in what :func:`parse_json` read meanwhile, the first ten."""

    __slots__ = ("_token",)

    def __enter__(self) -> list[str]:
        """Note from now on."""
        keys: list[str] = []
        self._token = _noted.set(keys)
        return keys

    def __exit__(self, *error: object) -> None:
        """Note no more."""
        _noted.reset(self._token)


def record_duplicate(key: str) -> None:
    """Note that a key of an object is there twice, where :class:`DuplicateKeys` asks for that."""
    keys = _noted.get()
    if keys is not None and len(keys) < _MOST_NOTED:
        keys.append(key)


def _refuse(key: str) -> NoReturn:
    raise ValueError(f"the key {shown(key)} occurs twice")


_NOTING = json.JSONDecoder(
    parse_float=_finite, parse_constant=_refuse_constant, object_pairs_hook=duplicate_key_hook(record_duplicate)
)
_UNIQUE = json.JSONDecoder(
    parse_float=_finite, parse_constant=_refuse_constant, object_pairs_hook=duplicate_key_hook(_refuse)
)


def json_decoder() -> json.JSONDecoder:
    """Return the decoder of :func:`parse_json`, which notes keys that are there twice if somebody wants to know."""
    return _DECODER if _noted.get() is None else _NOTING


def check_depth(value: object, levels: int = MAX_DEPTH) -> None:
    """Check that lists and objects in *value*, of JSON, are nested in at most *levels*.

    Raises:
        WireError: They are nested deeper.
    """
    level = [value]
    for _ in range(levels):
        level = [
            child
            for one in level
            for child in (one.values() if isinstance(one, dict) else one if isinstance(one, list) else ())
            if isinstance(child, (dict, list))
        ]
        if not level:
            return
    raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels")


def check_surrogates(value: object) -> None:
    """Check that no text in *value*, of JSON, contains half of a surrogate pair.

    Raises:
        WireError: One does.
    """
    try:
        json.dumps(value, ensure_ascii=False).encode()
    except UnicodeEncodeError:
        raise WireError("a text in the JSON contains half of a surrogate pair") from None


Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.conventions.description.Codec.read`."""

JsonMessage: TypeAlias = Mapping[str, object]
"""One message: a JSON object. Nobody changes it, because all parts that read it share it."""

TextT = TypeVar("TextT", str, bytes)

NO_READINGS: Readings = MappingProxyType({})


@lru_cache(maxsize=8)
def to_text(payload: bytes) -> str | None:
    """Return the text that *payload* is; None where it is none, or longer than what is looked at."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None


@lru_cache(maxsize=2)  # all parts of a device read the same message, one after the other
def to_json(payload: bytes) -> object:
    """Return what *payload* says in JSON, not to be changed; None where that is nothing."""
    try:
        return parse_json(payload)
    except WireError:
        return None


def as_fields(value: object) -> Mapping[str, object]:
    """Return the JSON object that *value*, read of JSON, is; an empty one where it is none."""
    return value if isinstance(value, dict) else _NO_FIELDS


def compact_json(value: object) -> str:
    """Return *value* in JSON without spaces."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def is_unknown(value: object) -> bool:
    """Return whether *value*, in the place of a number, means that the device does not know it.

    That is null, a number that is none or has no end, and the words that firmware has for these.
    """
    if isinstance(value, str):
        return means_unknown(value)
    return value is None or (isinstance(value, float) and not math.isfinite(value))


def read_number(
    capability: str, value: object, convert: Callable[[float], float | None] = float, unknown: object = None
) -> Readings:
    """Return what *value* reports of *capability*: a number, that it is unknown, or nothing.

    Args:
        capability: What the number is.
        value: What the message has in its place.
        convert: Makes the value of the number; None where that cannot be.
        unknown: The device's own text for a number that it does not know, beside those of :func:`is_unknown`.
    """
    if value == unknown:
        return {capability: None}
    number = to_number(value)
    if number is None:
        return {capability: None} if is_unknown(value) else NO_READINGS
    outside = convert(number)
    return NO_READINGS if outside is None else {capability: outside}


def meaning_reader(capability: str, meanings: Mapping[TextT, PlainValue]) -> Callable[[TextT], Readings]:
    """Return a reader of *capability* by a table of the texts, or payloads, that mean something."""
    return lambda text: {capability: meanings[text]} if text in meanings else NO_READINGS


def percent_of(value: object) -> float | None:
    """Return the number from 0 to 100 that *value* is; None, unknown, for anything else."""
    number = to_number(value)
    return number if number is not None and 0 <= number <= 100 else None


def number_of(value: object) -> float | None:
    """Return the number that a text or a JSON value is; None where it is none. As in Python, true is 1."""
    return float(value) if isinstance(value, bool) else to_number(value)


def whole_of(text: str) -> int | None:
    """Return the whole number that *text* is, without point or exponent; None where it is none."""
    try:
        return int(text) if len(text) <= _MAX_DIGITS else None
    except ValueError:
        return None


def numbers_of(text: str, count: int) -> tuple[float, ...] | None:
    """Return the *count* numbers that *text* has between commas; None where it has others."""
    parts = text.split(",", count)
    numbers = [number for part in parts if (number := number_of(part)) is not None]
    return tuple(numbers) if len(numbers) == len(parts) == count else None


def fields_of(text: str) -> Mapping[str, object]:
    """Return the JSON object that *text* is; empty where it is none."""
    if not text.lstrip().startswith("{"):
        return _NO_FIELDS
    try:
        message = parse_json(text)
    except WireError:
        return _NO_FIELDS
    return as_fields(message)


_NO_FIELDS: Mapping[str, object] = MappingProxyType({})
_MAX_DIGITS = 40
