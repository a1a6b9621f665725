"""Calculations with values, such as ``(temperature of office - 20) * 10``. Pure.

A sign stands between blanks, as names have hyphens. The work is bounded by the length of the text.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from homebot.errors import UsageError
from homebot.support.numbers import to_number
from homebot.words.tokens import MAX_QUERY

_MAX_DEPTH: Final = 20
_SIGN: Final = re.compile(r" ([-+*/]) ")
_QUOTED: Final = re.compile(r"\"[^\"]*\"|'[^']*'")
_CALL: Final = re.compile(r"(min|max|round|int|abs|default)\(")
_ROWS: Final = ("+-", "*/")
"""The signs, of which the later ones bind more."""


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """An operation: one of ``+ - * /``, or a function.

    ``int`` cuts the fraction off, ``round`` may have a number of digits, and ``default`` is the first that is known.
    """

    name: str
    parts: tuple["Term", ...]


Term: TypeAlias = float | str | Arithmetic
"""A number, the text of a value, or an operation with some."""


def read_calculation(text: str) -> Term:
    """Return the calculation *text*; a text without any sign or function is a value.

    Raises:
        UsageError: A bracket is missing, or some are too deep in others.
    """
    if len(text) > MAX_QUERY:
        return text
    reader = _CalculationReader(text)
    term = reader.sum(0)
    if reader.place != len(text):
        raise UsageError(f"{{{text}}}: {text[reader.place :].strip()!r} is too much; write '(a + b) * 2'")
    return term


def operands_of(term: Term) -> Iterator[str]:
    """Yield the texts of the values in *term*."""
    match term:
        case str():
            yield term
        case Arithmetic(parts=parts):
            for part in parts:
                yield from operands_of(part)


def with_operands(text: str, change: Callable[[str], str]) -> str:
    """Return the calculation *text* with each value in it as *change* returns it; as it is if it is none."""
    reader = _CalculationReader(text)
    try:
        reader.sum(0)
    except UsageError:
        return change(text)
    pieces, place = [], 0
    for begin, end in reader.spans:
        pieces += [text[place:begin], change(text[begin:end])]
        place = end
    return "".join([*pieces, text[place:]])


def calculated(term: Term, value_of: Callable[[str], float | None]) -> float | None:
    """Return the number *term*; None while a value is unknown that has no default, and for a division by zero."""
    if isinstance(term, float):
        return term
    if isinstance(term, str):
        return value_of(term)
    values = [calculated(part, value_of) for part in term.parts]
    known = [value for value in values if value is not None]
    if term.name == "default":
        return next(iter(known), None)
    if len(known) < len(values):
        return None
    try:
        result = float(_OPERATIONS[term.name](*known))
    except (ZeroDivisionError, OverflowError, ValueError):
        return None
    return result if math.isfinite(result) else None


_OPERATIONS: Final[Mapping[str, Callable[..., float]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "min": min,
    "max": max,
    "abs": abs,
    "int": math.trunc,
    "round": lambda value, digits=0.0: round(value, int(digits)),
}
_PARTS: Final = {"min": (2, 20), "max": (2, 20), "default": (2, 2), "round": (1, 2), "int": (1, 1), "abs": (1, 1)}
"""The least and the greatest number of parts of a function."""


class _CalculationReader:
    """A reader of one text from left to right.

    Attributes:
        place: The position of the next character.
        spans: The beginnings and ends of the values so far.
    """

    def __init__(self, text: str) -> None:
        self._text = text
        self._depth = 0
        self.place = 0
        self.spans: list[tuple[int, int]] = []

    def sum(self, row: int) -> Term:
        """Read operations with the signs of *row*, and those that bind more."""
        if row == len(_ROWS):
            return self._term()
        term = self.sum(row + 1)
        while (sign := _SIGN.match(self._text, self.place)) is not None and sign[1] in _ROWS[row]:
            self.place = sign.end()
            term = Arithmetic(sign[1], (term, self.sum(row + 1)))
        return term

    def _term(self) -> Term:
        self._skip_blanks()
        if (call := _CALL.match(self._text, self.place)) is not None:
            self.place = call.end()
            parts = self._in_brackets(call[1])
            least, most = _PARTS[call[1]]
            if not least <= len(parts) <= most:
                raise UsageError(f"{{{self._text}}}: {call[1]}() has {len(parts)} parts; write '{_EXAMPLES[call[1]]}'")
            return Arithmetic(call[1], tuple(parts))
        if self._text[self.place : self.place + 1] == "(":
            self.place += 1
            (term,) = self._in_brackets("(")
            return term
        begin, text = self.place, self._operand()
        if (number := to_number(text)) is not None:
            return number
        self.spans.append((begin, begin + len(text)))
        return text

    def _in_brackets(self, what: str) -> list[Term]:
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise UsageError(f"{{{self._text}}}: brackets too deep in others; {_MAX_DEPTH} is the limit")
        parts = [self.sum(0)]
        self._skip_blanks()
        while what != "(" and self._text[self.place : self.place + 1] == ",":
            self.place += 1
            parts.append(self.sum(0))
            self._skip_blanks()
        if self._text[self.place : self.place + 1] != ")":
            raise UsageError(f"{{{self._text}}}: a bracket is not closed")
        self.place += 1
        self._depth -= 1
        return parts

    def _operand(self) -> str:
        """Return the text up to the next sign, or to the end of the brackets around it."""
        begin, depth = self.place, 0
        while self.place < len(self._text):
            if (quoted := _QUOTED.match(self._text, self.place)) is not None:
                self.place = quoted.end()
                continue
            character = self._text[self.place]
            is_end = bool(self._depth) and character in "),"
            if not depth and (is_end or _SIGN.match(self._text, self.place)):
                break
            depth += (character == "(") - (character == ")")
            self.place += 1
        return self._text[begin : self.place].strip()

    def _skip_blanks(self) -> None:
        while self._text[self.place : self.place + 1] == " ":
            self.place += 1


_EXAMPLES: Final = {
    "min": "min(a, 100)",
    "max": "max(a, 0)",
    "default": "default(a, 20)",
    "round": "round(a, 1)",
    "int": "int(a)",
    "abs": "abs(a)",
}
