"""Payloads of devices: bounded JSON and texts, and readings from them. Pure."""

import json
import math
import re
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from functools import lru_cache
from types import MappingProxyType
from typing import NoReturn, TypeAlias, TypeVar

from pydantic_core import from_json
from pydantic_core import to_json as json_of

from homebot.conventions.unreadable import NO_READINGS as NO_READINGS
from homebot.conventions.unreadable import Readings as Readings
from homebot.conventions.unreadable import shown as shown
from homebot.conventions.unreadable import unreadable as unreadable
from homebot.devices.text.states import means_unknown
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.support.numbers import to_number
from homebot.support.strict_json import duplicate_key_hook

MAX_ANNOUNCEMENT_BYTES = 256 * 1024
"""Longest announcement of one device; one with a hundred parts has about 100 kB."""

MAX_STATE_BYTES = 256 * 1024
"""Longest message of a device's state."""

MAX_LONG_STATE_BYTES = 1024 * 1024
"""The same on a topic of announcements, with long messages: a large ``bridge/info`` of Zigbee2MQTT has states too."""

MAX_DEPTH = 64
"""Levels of lists and objects in JSON."""

_SPACES = " \t\n\r"
_ENDLESS = frozenset((math.inf, -math.inf))
_NO_NUMBER = re.compile(r'"(?:[^"\\]|\\.)*+"?|([-+]?\b(?:nan|inf(?:inity)?)\b)', re.IGNORECASE | re.DOTALL)
"""A text, which is left as it is, or what ``printf`` and some libraries write for a number that is none."""


def parse_json(
    payload: bytes | str, limit: int = MAX_STATE_BYTES, *, unique: bool = False, lenient: bool = False
) -> object:
    """Return the JSON value of *payload*, with finite numbers.

    Of duplicate keys the last one is used, see :class:`DuplicateKeys`.

    Args:
        payload: Text, or UTF-8.
        limit: Longest length, in bytes or characters.
        unique: Whether a duplicate key is an error.
        lenient: Whether NaN and infinities in an object or a list are null, in any spelling, as in states of devices.

    Raises:
        WireError: It is too long, no JSON as RFC 8259 has it (no NaN, no Infinity), nested deeper than 64 levels, or
            contains half of a surrogate pair.
    """
    if len(payload) > limit:
        raise WireError(f"a payload of {len(payload)} bytes is longer than {limit}")
    if not unique:
        try:
            value: object = from_json(payload, allow_inf_nan=False, cache_strings="keys")
        except (ValueError, TypeError):
            pass  # invalid JSON, and half of a surrogate pair, are refused below, with the reason
        else:
            recorded = _recorded.get() is not None
            if _is_plain(payload, value) if recorded else _is_flat_and_finite(value) or _is_finite(value, MAX_DEPTH):
                return value
    return _parse_slowly(payload, unique=unique, lenient=lenient)


def _decode(text: str, decoder: json.JSONDecoder, *, lenient: bool) -> object:
    start = len(text) - len(text.lstrip(_SPACES))
    if lenient and text.startswith(("{", "["), start):
        text = _NO_NUMBER.sub(lambda found: "null" if found[1] else found[0], text)
    value, end = decoder.raw_decode(text, start)
    if rest := text[end:].lstrip(_SPACES):
        raise json.JSONDecodeError("Extra data", text, len(text) - len(rest))
    return value


def _parse_slowly(payload: bytes | str, *, unique: bool, lenient: bool) -> object:
    """Return the JSON value of *payload*, or raise the reason; records duplicate keys by a call for each object."""
    try:
        text = payload.decode() if isinstance(payload, bytes) else payload
        value = _decode(text, _UNIQUE if unique else _RECORDING_DECODER, lenient=lenient)
    except RecursionError:
        raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels") from None
    except ValueError as error:
        raise WireError(f"{shown(payload)} is not JSON: {error}") from None
    if text.count("[") + text.count("{") > MAX_DEPTH:
        check_depth(value)
    if "\\u" in text or (isinstance(payload, str) and not text.isascii()):
        check_surrogates(value)
    return value


def _is_plain(payload: bytes | str, value: object) -> bool:
    """Return whether *value* has few levels, finite numbers and all keys of *payload*, each with an unescaped colon."""
    text = payload.encode() if isinstance(payload, str) else payload
    if text.count(b"{") + text.count(b"[") > MAX_DEPTH:
        return False
    encoded = json_of(value, inf_nan_mode="constants")
    if encoded == text:  # JSON without spaces, as most programs write it
        return True
    return b"Infinity" not in encoded and b"\\u" not in text and encoded.count(b":") == text.count(b":")


def _is_flat_and_finite(value: object) -> bool:
    """Return whether *value* is an object of one level, as most payloads, with finite numbers."""
    try:
        return isinstance(value, dict) and _ENDLESS.isdisjoint(value.values())
    except TypeError:  # lists and objects have no hash
        return False


def _is_finite(value: object, depth: int) -> bool:
    """Return whether *value* has at most *depth* levels and only finite numbers; ``1e999`` is infinite."""
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, list):
        return value not in _ENDLESS
    for item in value:
        kind = type(item)
        if kind is float:
            if item in _ENDLESS:
                return False
        elif (kind is dict or kind is list) and (depth <= 1 or not _is_finite(item, depth - 1)):
            return False
    return True


def parse_object(payload: bytes | str, limit: int = MAX_ANNOUNCEMENT_BYTES) -> dict[str, object]:
    """Return the JSON object in *payload*.

    Raises:
        WireError: As :func:`parse_json`, or it is JSON but no object.
    """
    value = parse_json(payload, limit)
    if not isinstance(value, dict):
        raise WireError(f"{shown(payload)} is not a JSON object")
    return value


def clean_text(text: str, limit: int = 120) -> str:
    """Return *text* for one line of output: without control and invisible characters, at most *limit* long.

    Markup is not escaped.
    """
    if len(text) <= limit and text.isprintable():
        return text.strip()
    kept = "".join(
        character if character.isprintable() or character in _JOINERS else " " for character in text[: 4 * limit]
    )
    return " ".join(kept.split())[:limit].rstrip()


def text_of(value: object, limit: int = 120) -> str:
    """Return *value* after :func:`clean_text`; empty if it is no text."""
    return clean_text(value, limit) if isinstance(value, str) else ""


_JOINERS = "\u200c\u200d"


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number in JSON")


def _finite(text: str) -> float:
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"{text[:20]} is too large a number")
    return number


_DECODER = json.JSONDecoder(parse_float=_finite, parse_constant=_refuse_constant)


_recorded: ContextVar[list[str] | None] = ContextVar("_recorded", default=None)
_MAX_RECORDED = 10


class DuplicateKeys:
    """A context that returns the first ten duplicate keys in payloads of :func:`parse_json`."""

    __slots__ = ("_token",)

    def __enter__(self) -> list[str]:
        """Begin recording."""
        keys: list[str] = []
        self._token = _recorded.set(keys)
        return keys

    def __exit__(self, *error: object) -> None:
        """End recording."""
        _recorded.reset(self._token)


def record_duplicate(key: str) -> None:
    """Record a duplicate key of an object in a context of :class:`DuplicateKeys`."""
    keys = _recorded.get()
    if keys is not None and len(keys) < _MAX_RECORDED:
        keys.append(key)


def _refuse(key: str) -> NoReturn:
    raise ValueError(f"the key {shown(key)} occurs twice")


_RECORDING_DECODER = json.JSONDecoder(
    parse_float=_finite, parse_constant=_refuse_constant, object_pairs_hook=duplicate_key_hook(record_duplicate)
)
_UNIQUE = json.JSONDecoder(
    parse_float=_finite, parse_constant=_refuse_constant, object_pairs_hook=duplicate_key_hook(_refuse)
)


def decode_json(text: str, at: int) -> tuple[object, int]:
    """Return the JSON value that begins at *at*, as :func:`parse_json`, and the index after it.

    Raises:
        ValueError: There is none.
    """
    return (_DECODER if _recorded.get() is None else _RECORDING_DECODER).raw_decode(text, at)


def check_depth(value: object, levels: int = MAX_DEPTH) -> None:
    """Check that lists and objects in *value*, of JSON, are nested in at most *levels*.

    Raises:
        WireError: They are nested deeper.
    """
    level = [value]
    for _ in range(levels):
        level = [
            child
            for parent in level
            for child in (parent.values() if isinstance(parent, dict) else parent if isinstance(parent, list) else ())
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


JsonMessage: TypeAlias = Mapping[str, object]
"""One message: a JSON object, never changed, because the parts of a device share it."""

TextT = TypeVar("TextT", str, bytes)


@lru_cache(maxsize=8)
def to_text(payload: bytes) -> str | None:
    """Return the UTF-8 text of *payload*; None if it is invalid or too long."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None


@lru_cache(maxsize=2)  # all parts of a device read the same message, one after the other
def to_json(payload: bytes) -> object:
    """Return the JSON value of *payload*, not to be changed; None if it is invalid."""
    try:
        return parse_json(payload, lenient=True)
    except WireError:
        return None


def as_fields(value: object) -> Mapping[str, object]:
    """Return *value* if it is a JSON object, otherwise an empty one."""
    return value if isinstance(value, dict) else _NO_FIELDS


def compact_json(value: object) -> str:
    """Return *value* in JSON without spaces."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def is_unknown(value: object) -> bool:
    """Return whether *value* stands for an unknown number: null, NaN, an infinity, or a word of firmware for these."""
    if isinstance(value, str):
        return means_unknown(value)
    return value is None or (isinstance(value, float) and not math.isfinite(value))


def read_number(
    capability: str, value: object, convert: Callable[[float], float | None] = float, unknown: object = None
) -> Readings:
    """Return the reading of a number: its value, None for an unknown one, or nothing.

    Args:
        convert: Converts the number; None if it is out of range.
        unknown: The device's own text for an unknown number, besides those of :func:`is_unknown`.
    """
    if value == unknown:
        return {capability: None}
    number = to_number(value)
    if number is None:
        return {capability: None} if is_unknown(value) else unreadable(value, "a number")
    outside = convert(number)
    return {capability: outside} if outside is not None else unreadable(value, f"a possible {capability}")


def meaning_reader(capability: str, meanings: Mapping[TextT, PlainValue]) -> Callable[[TextT], Readings]:
    """Return a reader of *capability* by a table of texts or payloads."""

    def read(text: TextT) -> Readings:
        if text in meanings:
            return {capability: meanings[text]}
        words = list(meanings)
        return unreadable(text, words if False not in meanings.values() else words[::-1])  # on or off

    return read


def percent_of(value: object) -> float | None:
    """Return *value* if it is a number from 0 to 100; otherwise None, unknown."""
    number = to_number(value)
    return number if number is not None and 0 <= number <= 100 else None


def read_progress(fields: Mapping[str, object], installing: str, percent: str) -> Readings:
    """Return whether an update is being installed, and how far; a percentage stands for true. Empty without fields."""
    if installing not in fields and percent not in fields:
        return NO_READINGS
    said = fields.get(installing)
    share = percent_of(fields.get(percent) if isinstance(said, bool | None) else said)
    runs = said if isinstance(said, bool) else True if share is not None else None
    return {"running": runs, "update_progress": share if runs else None}


def number_of(value: object) -> float | None:
    """Return the number in a text or a JSON value; None for none. As in Python, true is 1."""
    return float(value) if isinstance(value, bool) else to_number(value)


def whole_of(text: str) -> int | None:
    """Return the whole number in *text*, without point or exponent; None for none."""
    try:
        return int(text) if len(text) <= _MAX_DIGITS else None
    except ValueError:
        return None


def numbers_of(text: str, count: int) -> tuple[float, ...] | None:
    """Return the *count* numbers between commas in *text*; None for another count."""
    parts = text.split(",", count)
    numbers = [number for part in parts if (number := number_of(part)) is not None]
    return tuple(numbers) if len(numbers) == len(parts) == count else None


def fields_of(text: str) -> Mapping[str, object]:
    """Return the JSON object in *text*; empty for none."""
    if not text.lstrip().startswith("{"):
        return _NO_FIELDS
    try:
        message = parse_json(text, lenient=True)
    except WireError:
        return _NO_FIELDS
    return as_fields(message)


_NO_FIELDS: Mapping[str, object] = MappingProxyType({})
_MAX_DIGITS = 40
