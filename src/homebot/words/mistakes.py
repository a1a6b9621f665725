"""Mistakes in the texts of routines and goals, and answers to goals, as other languages say them. Pure.

A row of ``languages/mistakes.json`` is the form of an English message, and those of German, French, Spanish, Dutch and
Italian. Values of the fields ``reason`` and ``advice`` are messages themselves, ``names`` are joined by "and" or "or",
``trigger``, ``condition``, ``step`` and ``wish`` are texts of people, ``steps`` several in quotation marks, and
``text`` is a whole text in quotation marks; each language has its own ``example``. Others stay as they are.
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Final, TypeVar, final

from homebot.errors import UsageError
from homebot.words.own_language import TextKind, hint_for, in_language, language_of, reading_of

COLUMNS: Final = ("de", "fr", "es", "nl", "it")
FIELD: Final = re.compile(r"\{(\w+)\}")
_QUOTED: Final = re.compile(r"'(?:[^'\\]++|\\.)*+'|\"(?:[^\"\\]++|\\.)*+\"")
_SIGN: Final = re.compile(r"(?<! )[:;] ")
"""Not those of French, as a message may be in a language already."""

_MAX_CLAUSES: Final = 8
_JOINTS: Final = (" or ", " and ", " more")


ReadT = TypeVar("ReadT")


def read_in_any_language(text: str, kind: TextKind, read: Callable[[str], ReadT]) -> ReadT:
    """Return the result of *read* for the English for *text*.

    Raises:
        UsageError: It is none; a text in another language is answered in it.
    """
    language, english = reading_of(text, kind)
    try:
        return read(english or text)
    except UsageError as exc:
        if english:
            raise UsageError(mistake_in(language, str(exc).replace(repr(english), repr(text)))) from exc
        if hint := hint_for(text, kind):
            raise UsageError(hint) from exc
        raise


def mistake_in(language: str, message: str) -> str:
    """Return the lines of an English *message* as *language* says them, or that of the text that a line quotes first.

    A message without a row stays English; names, and texts of people, stay as they are.
    """
    return "\n".join(_table().said(line, _language_of_quoted(line) or language) for line in message.split("\n"))


@cache
def _table() -> "MistakeTable":
    path = Path(__file__).parent / "languages" / "mistakes.json"
    return MistakeTable(json.loads(path.read_text(encoding="utf-8")))


def _language_of_quoted(line: str) -> str:
    """Return the language of the first quoted text in *line*; empty if it tells none."""
    begin = min((place for place in map(line.find, "'\"") if place >= 0), default=len(line))
    quoted = _QUOTED.match(line, begin)
    return "" if quoted is None else language_of(quoted[0][1:-1])


@final
class MistakeTable:
    """A table of messages.

    Args:
        table: By the form of an English message, those of the :data:`COLUMNS`.
    """

    def __init__(self, table: Mapping[str, Sequence[str]]) -> None:
        forms = sorted(table, key=lambda form: -len(FIELD.sub("", form)))
        self._rows = [(FIELD.split(form), table[form]) for form in forms]

    def said(self, text: str, language: str, clauses: int = _MAX_CLAUSES) -> str:
        """Return the English *text* by its row, else clause by clause, at most so many."""
        if language not in COLUMNS or not clauses:
            return text
        for form, own in self._rows:
            if (values := _values(form, text)) is not None:
                said = {form[at]: self._value(form[at], value, language, clauses - 1) for at, value in values.items()}
                pieces = FIELD.split(own[COLUMNS.index(language)])
                return "".join(said.get(piece, f"{{{piece}}}") if at % 2 else piece for at, piece in enumerate(pieces))
        sign = _SIGN.search(text, _end_of_quoted(text, 0))
        if sign is None:
            return text
        head, tail = text[: sign.start()], text[sign.end() :]
        own_head = head if sign[0] == ": " else self.said(head, language, 1)  # or it is a name, or the place
        own = own_head, self.said(tail, language, clauses - 1)
        return (sign[0] if own == (head, tail) else self.said(sign[0], language, 1)).join(own)

    def _value(self, field: str, value: str, language: str, clauses: int) -> str:
        match field.rstrip("123456789"):
            case "reason" | "advice":
                return self.said(value, language, clauses)
            case "trigger" | "condition" | "step" | "wish" as kind:
                return in_language(value, kind, language)
            case "steps":
                value = _QUOTED.sub(lambda step: f"'{in_language(step[0][1:-1], 'step', language)}'", value)
            case "names":
                pass
            case _:
                return value
        for joint in _JOINTS:
            value = value.replace(joint, self.said(joint, language, 1))
        return value


def _end_of_quoted(text: str, place: int) -> int:
    quoted = _QUOTED.match(text, place)
    return place if quoted is None else quoted.end()


def _values(form: Sequence[str], text: str) -> dict[int, str] | None:
    """Return the values of the fields of *form* in *text*, by their places in it; None if it has another form."""
    if not text.startswith(form[0]):
        return None
    place, values = len(form[0]), dict[int, str]()
    for at in range(1, len(form), 2):
        literal = form[at + 1]
        if form[at].startswith("text"):
            end = _end_of_quoted(text, place)
        elif at == len(form) - 2:
            end = len(text) - len(literal)
        else:
            end = text.find(literal, place + 1)
        value = text[place:end]
        if not value or not text.startswith(literal, end) or (form[at].startswith("name") and _SIGN.search(value)):
            return None
        values[at], place = value, end + len(literal)
    return values if place == len(text) else None
