"""JSON of many megabytes, parsed in slices, so that other work can be done in between. Pure.

`json` parses 32 MiB in a second, and lets no other thread run meanwhile. Here a window of the text is parsed at a time;
a list or an object that is longer than the window is taken member by member.
"""

from __future__ import annotations

import codecs
import json
import re
from collections.abc import Generator
from typing import Final, TypeAlias

from homebot.conventions.payload import (
    MAX_DEPTH,
    check_depth,
    check_surrogates,
    json_decoder,
    note_duplicate,
    shown,
)
from homebot.errors import WireError

__all__ = ["WINDOW_BYTES", "is_longer_than", "parse_in_slices"]

WINDOW_BYTES: Final = 64 * 1024
"""Bytes that are parsed without a pause; a longer text or a longer run of blanks is one slice as well."""

Slices: TypeAlias = Generator[None, None, object]
_SPACES: Final = " \t\n\r"
_BRACKETS: Final = frozenset("[{")
_CLOSED: Final = frozenset('[{"')
_NUMBER_SIGNS: Final = len("e-")
"""Characters of a number that are none without a digit behind them, which may be in the next window."""

_SHORT: Final = 200
"""Characters; members that are shorter are parsed many at a time."""

_NO_SPACE: Final = re.compile(r"[^ \t\n\r]")


def parse_in_slices(payload: bytes, limit: int, window: int = WINDOW_BYTES) -> Slices:
    """Parse JSON as :func:`homebot.conventions.payload.parse_json` does, and yield between two slices.

    Args:
        payload: UTF-8.
        limit: Its longest length in bytes.
        window: Bytes of a slice; a number is at most as long.

    Returns:
        The value, when all of it was parsed.

    Raises:
        WireError: It is longer than *limit* bytes, or as :func:`~homebot.conventions.payload.parse_json`.
    """
    if len(payload) > limit:
        raise WireError(f"a payload of {len(payload)} bytes is longer than {limit}")
    try:
        parser = _SlicedText(payload, window)
        parser.skip_spaces()
        value = yield from parser.parse_value(0)
        parser.skip_spaces()
        is_all = not parser.character
    except RecursionError:
        raise WireError(f"JSON is nested deeper than {MAX_DEPTH} levels") from None
    except ValueError as error:
        problem = error.msg if isinstance(error, json.JSONDecodeError) else str(error)
        raise WireError(f"{shown(payload)} is not JSON: {problem}") from None
    if not is_all:
        raise WireError(f"{shown(payload)} is not JSON: it goes on after its end")
    return value


def is_longer_than(value: object, limit: int) -> bool:
    """Return whether *value*, of JSON, has more than *limit* characters when it is written; a little less may count."""
    left = limit
    waiting = [value]
    while waiting:
        one = waiting.pop()
        left -= len(one) + 1 if isinstance(one, (str, list, dict)) else 1
        if left < 0:
            return True
        if isinstance(one, dict):
            waiting.extend(one)
            waiting.extend(one.values())
        elif isinstance(one, list):
            waiting.extend(one)
    return False


class _SlicedText:
    """A payload, and the window of its text that is parsed now.

    Attributes:
        text: The window.
        at: Where in the window the next value or sign begins.
    """

    __slots__ = (
        "_decode",
        "_ends_here",
        "_is_next_slice",
        "_is_tried",
        "_payload",
        "_start",
        "_stop",
        "_window",
        "at",
        "text",
    )

    def __init__(self, payload: bytes, window: int) -> None:
        self._payload = payload
        self._window = window
        self._start = self._stop = 0
        self._decode = json_decoder().raw_decode
        self.text = ""
        self.at = 0
        self._is_next_slice = self._is_tried = False
        self._read_from(0, window)

    @property
    def character(self) -> str:
        """The character at :attr:`at`; empty at the end of the payload."""
        if self.at >= len(self.text) and not self._ends_here:
            self._read_from(self._stop, self._window)
        return self.text[self.at : self.at + 1]

    def skip_spaces(self) -> None:
        """Move behind blanks."""
        while (sign := self.character) and sign in _SPACES:
            found = _NO_SPACE.search(self.text, self.at)
            self.at = len(self.text) if found is None else found.start()

    def parse_value(self, depth: int) -> Slices:
        """Parse the value that begins here, inside *depth* lists and objects; yield before each further slice."""
        size = self._window
        while True:
            if self._is_next_slice:
                self._is_next_slice = False
                yield
            begins = self.character
            try:
                value, end = self._decode(self.text, self.at)
            except ValueError:
                if self._has_all(begins):
                    raise
            else:
                if begins in _CLOSED or self._ends_here or end + _NUMBER_SIGNS < len(self.text):
                    self._check(value, end, depth)
                    self.at = end
                    return value
            if self.at > 0:
                self._read_from(self._start + len(self.text[: self.at].encode()), self._window)
            elif begins == "[":
                return (yield from self._parse_list(depth + 1))
            elif begins == "{":
                return (yield from self._parse_object(depth + 1))
            elif begins == '"':
                size *= 8
                self._read_from(self._start, size)
            else:
                raise ValueError("a number is too long")

    def _parse_list(self, depth: int) -> Slices:
        found: list[object] = []
        self._open(depth)
        if self.character == "]":
            self.at += 1
            return found
        while True:
            begins_at = self.at
            found.append((yield from self.parse_value(depth)))
            if 0 < self.at - begins_at < _SHORT and isinstance(several := self._parse_several("[]", depth), list):
                found += several
            if not self._goes_on("]"):
                return found

    def _parse_object(self, depth: int) -> Slices:
        found: dict[str, object] = {}
        self._open(depth)
        if self.character == "}":
            self.at += 1
            return found
        while True:
            begins_at = self.at
            name = yield from self._parse_name(depth)
            value = yield from self.parse_value(depth)
            self._add(found, {name: value})
            if 0 < self.at - begins_at < _SHORT and isinstance(several := self._parse_several("{}", depth), dict):
                self._add(found, several)
            if not self._goes_on("}"):
                return found

    def _parse_name(self, depth: int) -> Generator[None, None, str]:
        if self.character != '"':
            raise ValueError("a name in quotes is expected")
        name = yield from self.parse_value(depth)
        assert isinstance(name, str)  # noqa: S101 - for the type checker: it begins with a quote
        self.skip_spaces()
        if self.character != ":":
            raise ValueError("':' is expected")
        self.at += 1
        self.skip_spaces()
        return name

    def _parse_several(self, brackets: str, depth: int) -> object:
        """Parse the members that follow in this window, all at once; return None where that does not work.

        The text is cut before a comma. If what is before it is a row of whole members, that comma is no part of one.
        """
        if self._is_tried or self.text[self.at : self.at + 1] != ",":
            return None
        self._is_tried = True
        last = self.text[self.at - 1]
        cut = self.text.rfind(f"{last}," if last in "]}" else ",", self.at + 1)
        if cut < 0:
            return None
        end = cut + (last in "]}")
        try:
            text = f"{brackets[0]}{self.text[self.at + 1 : end]}{brackets[1]}"
            value, length = self._decode(text)
        except ValueError:
            return None
        if length < len(text) or not value:
            return None
        self._check(value, end, depth - 1)
        self.at = end
        return value

    def _add(self, found: dict[str, object], members: dict[str, object]) -> None:
        if not found.keys().isdisjoint(members):
            note_duplicate(next(name for name in members if name in found))
        found |= members

    def _has_all(self, begins: str) -> bool:
        """Return whether a value that begins so is whole in the window, so that an error in it is one."""
        if begins in _BRACKETS:
            return False
        return self._ends_here or (begins != '"' and self.at == 0)

    def _open(self, depth: int) -> None:
        if depth > MAX_DEPTH:
            raise RecursionError
        self.at += 1
        self.skip_spaces()

    def _goes_on(self, closing: str) -> bool:
        """Move behind the comma or the *closing* bracket; return whether it was a comma."""
        self.skip_spaces()
        sign = self.character
        if sign not in {",", closing}:
            raise ValueError(f"',' or '{closing}' is expected")
        self.at += 1
        if sign == closing:
            return False
        self.skip_spaces()
        return True

    def _check(self, value: object, end: int, depth: int) -> None:
        if isinstance(value, (list, dict)):
            brackets = self.text.count("[", self.at, end) + self.text.count("{", self.at, end)
            if brackets > MAX_DEPTH - depth:
                check_depth(value, MAX_DEPTH - depth)
        if self.text.find("\\u", self.at, end) >= 0:
            check_surrogates(value)

    def _read_from(self, start: int, size: int) -> None:
        """Read the window that begins at byte *start*; a character that it would cut is left for the next."""
        piece = self._payload[start : start + size]
        self._ends_here = start + size >= len(self._payload)
        self.text, used = codecs.utf_8_decode(piece, "strict", self._ends_here)
        self._start, self._stop, self.at = start, start + used, 0
        self._is_next_slice, self._is_tried = True, False
