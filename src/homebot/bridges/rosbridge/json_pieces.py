"""Strict JSON in pieces: long arrays of numbers, such as maps and images, are parsed a few thousand at a time. Pure.

Everything else is bounded in its number of values: a megabyte of text takes 3 ms, but one of empty lists 250 ms.
"""

import json
import re
from collections.abc import Generator, Iterator
from typing import Any, Final

from homebot.support.strict_json import parse_strict

MAX_NESTING: Final = 100  # no message is this deep, and code that walks a value may recurse
MAX_VALUES: Final = 20_000
MAX_NUMBERS: Final = 1_000_000
"""Most numbers in long arrays: an image of 640 by 480 pixels in three colours has 921,600."""

_SHORT: Final = 65_536
"""Most characters of text parsed at once."""

_STRING: Final = re.compile(r'"[^"\\]*+(?:\\.[^"\\]*+)*+(?:"|\\?\Z)', re.DOTALL)
"""A text, also an unterminated one, in which each quotation mark would otherwise be tried as a beginning."""

_LONG_ARRAY: Final = re.compile(_STRING.pattern + r"|\[(\s*+[-0-9][-+0-9.eE,\s]{4096,}+)\]", re.DOTALL)

_MAX_QUOTES: Final = 4 * MAX_VALUES
"""Most unescaped quotation marks, enough for the allowed number of values: each costs 0.5 µs."""

_MARK: Final = "-Infinity"
"""Placeholder of a long array until that is parsed; not JSON, so that texts containing it are parsed at once."""


class RefusedJsonError(ValueError):
    """JSON that is refused; the message continues a sentence after "it"."""


def parse_in_pieces(text: str) -> Generator[None, None, object]:
    """Parse *text* in steps, between which other tasks may run.

    Raises:
        RefusedJsonError: It has more than 20,000 values, or a million numbers in long arrays, is nested more than 100
            deep, or is not valid Unicode.
        DuplicateKeyError, ValueError, RecursionError: As :func:`parse_strict`.
    """
    arrays: list[tuple[int, int]] = []
    rest = text
    if text.count('"') - text.count('\\"') > _MAX_QUOTES:
        raise _too_many_values()
    if _openings(text) >= MAX_VALUES:
        bare = _STRING.sub("", text)
        yield
        if _openings(bare) >= MAX_VALUES:
            raise _too_many_values()
    if len(text) > _SHORT and _MARK not in text:
        rest = _LONG_ARRAY.sub(lambda match: _put_aside(match, arrays), text)
        yield
    _check_size(rest, sum(text.count(",", *span) for span in arrays))
    lists: list[list[object]] = []
    value = parse_strict(rest, lambda name: _new_list(lists) if arrays and name == _MARK else float(name))
    if _openings(rest) > MAX_NESTING:
        _check_nesting(value)
    if "\\ud" in rest or "\\uD" in rest:
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as exc:
            raise RefusedJsonError("contains half of a surrogate pair, which is not Unicode") from exc
    for numbers, span in zip(lists, arrays, strict=True):
        yield from _read_numbers(numbers, text, *span)
    return value


def _openings(text: str) -> int:
    return text.count("[") + text.count("{")


def _read_numbers(found: list[object], text: str, start: int, end: int) -> Iterator[None]:
    """Append the numbers between *start* and *end* of *text* to *found*, piece by piece."""
    while start < end:
        cut = end if end - start <= _SHORT else text.rfind(",", start, start + _SHORT)
        numbers: Any = json.loads(f"[{text[start : max(cut, start)]}]")
        if not numbers:
            raise ValueError("a list has a comma without a number")
        found.extend(numbers)
        start = cut + 1
        yield
    if text[end - 1] == ",":
        raise ValueError("a list ends in a comma")


def _put_aside(found: re.Match[str], arrays: list[tuple[int, int]]) -> str:
    if found[1] is None:
        return found[0]
    arrays.append(found.span(1))
    return _MARK


def _new_list(lists: list[list[object]]) -> list[object]:
    lists.append([])
    return lists[-1]


def _check_size(text: str, numbers: int) -> None:
    if numbers >= MAX_NUMBERS:
        raise RefusedJsonError(f"holds more than {MAX_NUMBERS:,} numbers; send bytes as base64 text")
    if _separators(text) >= MAX_VALUES and _separators(_STRING.sub("", text)) >= MAX_VALUES:
        raise _too_many_values()


def _too_many_values() -> RefusedJsonError:
    return RefusedJsonError(f"holds more than {MAX_VALUES:,} values beside long lists of numbers")


def _separators(text: str) -> int:
    return text.count(",") + text.count("[") + text.count("{")


def _check_nesting(value: object) -> None:
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > MAX_NESTING:
            raise RefusedJsonError(f"is nested more than {MAX_NESTING} deep")
        level = [
            item
            for parent in level
            for item in (parent.values() if isinstance(parent, dict) else parent if isinstance(parent, list) else ())
            if isinstance(item, dict | list)
        ]
