"""Fields of a JSON object from outside, asked for by name and type. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from homebot.errors import WireError

MAX_TEXT: Final = 1000
"""Most characters of a text for people; longer ones are cut."""

_MAX_LISTED = 300
_MAX_NAME = 200
_MAX_SHOWN = 60
_MAX_NUMBER = 10**20


class Fields:
    """One JSON object, with fields asked for by name and type; a missing one is empty.

    Args:
        value: The expected object.
        path: Its place, for errors: ``properties.on.forms[0]``.

    Raises:
        WireError: It is not an object.
    """

    def __init__(self, value: object, path: str) -> None:
        self._path = path
        if not isinstance(value, Mapping):
            raise self._wrong("", "an object", value)
        self._value: Mapping[object, object] = value

    def __contains__(self, name: str) -> bool:
        return name in self._value

    def problem(self, name: str, problem: str) -> WireError:
        """Return the error for a *problem* with a field."""
        return WireError(f"{self.where(name)}: {problem}")

    def text(self, name: str, *, required: bool = False) -> str:
        """Return a text without control characters; raise WireError for another type, or if *required* and missing."""
        value = self._value.get(name)
        if value is None and not required:
            return ""
        if not isinstance(value, str) or (required and not value.strip()):
            raise self._wrong(name, "a text", value)
        return "".join(sign if sign.isprintable() else " " for sign in value[:MAX_TEXT]).strip()

    def flag(self, name: str) -> bool:
        """Return a boolean; False if it is missing."""
        value = self._value.get(name, False)
        if not isinstance(value, bool):
            raise self._wrong(name, "true or false", value)
        return value

    def number(self, name: str) -> float | None:
        """Return a number; None if it is missing."""
        value = self._value.get(name)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._wrong(name, "a number", value)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._wrong(name, "a finite number", value)
        return number

    def texts(self, name: str) -> tuple[str, ...]:
        """Return a text or a list of texts, as a tuple."""
        value = self._value.get(name)
        if value is None:
            return ()
        listed = value if isinstance(value, list) else [value]
        if not all(isinstance(text, str) for text in listed):
            raise self._wrong(name, "a text or a list of texts", value)
        self._check_length(name, len(listed))
        return tuple(str(text)[:MAX_TEXT] for text in listed)

    def plain(self, name: str) -> object:
        """Return an unchecked field; None if it is missing."""
        return self._value.get(name)

    def listed(self, name: str) -> tuple[object, ...]:
        """Return the elements of a list."""
        value = self._value.get(name)
        if value is None:
            return ()
        if not isinstance(value, list):
            raise self._wrong(name, "a list", value)
        self._check_length(name, len(value))
        return tuple(value)

    def inner(self, name: str) -> Fields:
        """Return the object in a field; an empty one if it is missing."""
        return Fields(self._value.get(name, {}), self.where(name))

    def names(self) -> tuple[str, ...]:
        """Return the names of all fields; raise WireError for more than 300, or one longer than 200 characters."""
        self._check_length("", len(self._value))
        for name in self._value:
            if not isinstance(name, str) or len(name) > _MAX_NAME:
                raise self.problem(str(name), f"a name of at most {_MAX_NAME} characters is expected")
        return tuple(str(name) for name in self._value)

    def _check_length(self, name: str, length: int) -> None:
        if length > _MAX_LISTED:
            raise self.problem(name, f"{length} is too many; the limit is {_MAX_LISTED}")

    def where(self, name: str) -> str:
        """Return the place of a field, for errors."""
        text = name if len(name) <= _MAX_SHOWN else f"{name[:_MAX_SHOWN]}…"
        text = text if text.isprintable() else ascii(text)
        return f"{self._path}.{text}" if self._path and name else text or self._path or "the description"

    def _wrong(self, name: str, expected: str, value: object) -> WireError:
        if value is None:
            return self.problem(name, f"is missing; expected {expected}")
        return self.problem(name, f"expected {expected}, got {_show(value)}")


def _show(value: object) -> str:
    match value:
        case dict():
            return "an object"
        case list():
            return "a list"
        case bool():
            return "true" if value else "false"
        case int() if abs(value) >= _MAX_NUMBER:
            return "a finite number"
        case _:
            return ascii(value[:_MAX_SHOWN] if isinstance(value, str) else value)
