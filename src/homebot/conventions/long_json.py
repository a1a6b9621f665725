"""JSON of many megabytes, parsed item by item with pauses for other work. Pure.

`json` parses 32 MiB in a second, without a turn for other threads.
"""

import json
import re
from collections.abc import Generator, Iterator
from typing import Final, TypeAlias

from homebot.conventions.payload import (
    MAX_DEPTH,
    check_depth,
    check_surrogates,
    decode_json,
    parse_json,
    record_duplicate,
    shown,
)
from homebot.errors import WireError

_Place: TypeAlias = tuple[object, int]
"""A value, and the index after it."""

_LEVELS: Final = 2
"""Levels that are parsed by their members: the pages of a list are mostly lists in an object."""

_SPACES: Final = b" \t\n\r"
_NO_SPACE: Final = re.compile(r"[^ \t\n\r]")
_CLOSING: Final = {"[": "]", "{": "}"}


def parse_list(payload: bytes, limit: int) -> Iterator[object]:
    """Yield the items of a JSON list.

    Raises:
        WireError: As :func:`~homebot.conventions.payload.parse_json`, or it is JSON but no list; items yielded before
            are invalid then.
    """
    if len(payload) > limit or not payload.lstrip(_SPACES).startswith(b"["):
        value = parse_json(payload, limit)
        raise WireError(f"{shown(value)} is not a list")
    try:
        text = payload.decode()
        at = _after_spaces(text, text.index("[") + 1)
        while text[at : at + 1] != "]":
            value, at = _decode(text, at, MAX_DEPTH - 1)
            yield value
            at = _next_member(text, at, "]")
        _check_end(text, at + 1)
    except RecursionError:
        raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels") from None
    except ValueError as error:
        raise WireError(f"{shown(payload)} is not JSON: {error}") from None


def parse_in_slices(payload: bytes, limit: int) -> Generator[int, None, object]:
    """Parse JSON as :func:`~homebot.conventions.payload.parse_json`, with a pause after each member.

    Yields:
        The number of parsed characters. Values below the second level are parsed without a pause.

    Returns:
        The value.

    Raises:
        WireError: It is longer than *limit* bytes, or as :func:`~homebot.conventions.payload.parse_json`.
    """
    if len(payload) > limit:
        raise WireError(f"a payload of {len(payload)} bytes is longer than {limit}")
    try:
        text = payload.decode()
        value, at = yield from _parse(text, _after_spaces(text, 0), _LEVELS)
        _check_end(text, at)
    except RecursionError:
        raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels") from None
    except ValueError as error:
        raise WireError(f"{shown(payload)} is not JSON: {error}") from None
    return value


def is_longer_than(value: object, limit: int) -> bool:
    """Return whether the JSON *value* has more than about *limit* characters as text."""
    left = limit
    waiting = [value]
    while waiting:
        item = waiting.pop()
        left -= len(item) + 1 if isinstance(item, (str, list, dict)) else 1
        if left < 0:
            return True
        if isinstance(item, dict):
            waiting.extend(item)
            waiting.extend(item.values())
        elif isinstance(item, list):
            waiting.extend(item)
    return False


def _parse(text: str, at: int, levels: int) -> Generator[int, None, _Place]:
    """Parse the value that begins at *at*; *levels* lists and objects by their members."""
    opening = text[at : at + 1]
    closing = _CLOSING.get(opening)
    if closing is None or levels == 0:
        value, at = _decode(text, at, MAX_DEPTH - _LEVELS + levels)
        yield at
        return value, at
    values: list[object] = []
    names: list[str] = []
    at = _after_spaces(text, at + 1)
    while text[at : at + 1] != closing:
        if opening == "{":
            name, at = _parse_name(text, at)
            names.append(name)
        value, at = yield from _parse(text, at, levels - 1)
        values.append(value)
        at = _next_member(text, at, closing)
    return (values if opening == "[" else _object(names, values)), at + 1


def _parse_name(text: str, at: int) -> tuple[str, int]:
    """Parse the name of a member; return it and the index of its value."""
    name, at = decode_json(text, at)
    at = _after_spaces(text, at)
    check_surrogates(name)
    if not isinstance(name, str) or text[at : at + 1] != ":":
        raise json.JSONDecodeError("Expecting a name in quotes and ':'", text, at)
    return name, _after_spaces(text, at + 1)


def _object(names: list[str], values: list[object]) -> dict[str, object]:
    fields = dict(zip(names, values, strict=True))
    if len(fields) < len(names):
        known: set[str] = set()
        for name in names:
            if name in known:
                record_duplicate(name)
            known.add(name)
    return fields


def _decode(text: str, at: int, levels: int) -> _Place:
    """Decode the value that begins at *at*, with at most *levels* lists and objects in one another."""
    value, end = decode_json(text, at)
    if text.count("[", at, end) + text.count("{", at, end) > levels:
        check_depth(value, levels)
    if text.find("\\u", at, end) >= 0:
        check_surrogates(value)
    return value, end


def _next_member(text: str, at: int, closing: str) -> int:
    """Return the index of the next member after a comma, or that of *closing*."""
    at = _after_spaces(text, at)
    if text[at : at + 1] == closing:
        return at
    if text[at : at + 1] != ",":
        raise json.JSONDecodeError("Expecting ',' delimiter", text, at)
    at = _after_spaces(text, at + 1)
    if text[at : at + 1] == closing:
        raise json.JSONDecodeError("Expecting value", text, at)
    return at


def _after_spaces(text: str, at: int) -> int:
    match = _NO_SPACE.search(text, at)
    return len(text) if match is None else match.start()


def _check_end(text: str, at: int) -> None:
    if (end := _after_spaces(text, at)) < len(text):
        raise json.JSONDecodeError("Extra data", text, end)
