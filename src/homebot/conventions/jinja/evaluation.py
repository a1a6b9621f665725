"""One rendering of a template: the values of its names, its output, and the work left to it."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import final

from homebot.conventions.jinja.limits import MAX_NUMBER_BITS, MAX_STEPS, MAX_TEXT, TemplateError
from homebot.conventions.jinja.values import UNDEFINED, text, weigh

__all__ = ["Run"]


@final
class Run:
    """One rendering.

    Args:
        names: The values of the template's names at its start.
        now: The time, with its time zone, if it is known.
    """

    __slots__ = ("_length", "_names", "_parts", "_scopes", "_steps", "now")

    def __init__(self, names: Mapping[str, object], now: datetime | None) -> None:
        self.now = now
        self._names = names
        self._scopes: list[dict[str, object]] = [{}]
        self._parts: list[str] = []
        self._steps = MAX_STEPS
        self._length = 0

    def lookup(self, name: str) -> object:
        """Return the value of *name* here; UNDEFINED if it has none."""
        for scope in reversed(self._scopes):
            if name in scope:
                return scope[name]
        return self._names.get(name, UNDEFINED)

    def assign(self, name: str, value: object) -> None:
        """Let *name* mean *value* in the innermost scope."""
        self._scopes[-1][name] = value

    def enter(self) -> None:
        """Open a scope: its assignments end with it."""
        self._scopes.append({})

    def leave(self) -> None:
        """Close the innermost scope."""
        self._scopes.pop()

    def spend(self, steps: int) -> None:
        """Count work that is about to be done, or has just been.

        Raises:
            TemplateError: It is too much.
        """
        self._steps -= steps
        if self._steps < 0:
            raise TemplateError("it does too much work")

    def handle(self, value: object) -> object:
        """Return *value*, its size counted as work.

        Raises:
            TemplateError: It is larger than a value may be.
        """
        if value.__class__ in _SMALL:
            return value
        if isinstance(value, (str, bytes)):
            if len(value) > MAX_TEXT:
                raise TemplateError(f"a text has more than {MAX_TEXT} characters")
            self.spend(1 + len(value) // 256)
        elif isinstance(value, (list, tuple, dict)):
            self.spend(1 + weigh(value) // 4)
        elif isinstance(value, int):
            if value.bit_length() > MAX_NUMBER_BITS:
                raise TemplateError(f"a number has more than {MAX_NUMBER_BITS} bits")
        elif isinstance(value, complex):
            raise TemplateError("a number is not real")
        return value

    def write(self, value: object) -> None:
        """Add the text of *value* to the output.

        Raises:
            TemplateError: The output gets too long.
        """
        if isinstance(value, (list, tuple, dict)):
            self.spend(1 + weigh(value) // 4)
        part = text(value)
        self._length += len(part)
        if self._length > MAX_TEXT:
            raise TemplateError(f"the text is longer than {MAX_TEXT} characters")
        self._parts.append(part)

    def written(self, start: int = 0) -> str:
        """Take the output from *start*, a :meth:`mark`, on."""
        taken = "".join(self._parts[start:])
        del self._parts[start:]
        return taken

    def mark(self) -> int:
        """Return where the output stands, for :meth:`written`."""
        return len(self._parts)


_SMALL = frozenset({bool, float, type(None)})
