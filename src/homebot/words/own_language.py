"""Texts of routines in other languages, as the English ones that the grammars read, and back. Pure.

A language is a table ``languages/CODE.json``. Its forms stand by the English form, the one that is shown first. Slots
are ``x`` for a device, ``c`` a commanded one, ``r`` a room, ``p`` a person or another name, ``t`` a length of time,
``h`` and ``k`` times of day, ``u`` an event of the sun, ``d`` days, ``e`` and ``f`` days of the year or months, ``n`` a
number with its unit, ``v`` a measured value, ``w`` a type after "no", ``a`` all of one, ``s`` and ``i`` states, ``g``
triggers, ``m`` a message, ``j`` a value in braces, and ``o`` and ``b`` other texts, which stay as names do; ``q``,
``y`` and ``l`` are a second value, device and length. Values in braces may stand for numbers, and in messages.
``awaited`` has the words of a state that is awaited; one with none goes to the end, as the verb of German and Dutch.
``moved`` are patterns of texts that are written otherwise before they are read.
A text tells its language itself, so that it means the same in a house, its export, a trial and on another machine.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from itertools import chain, takewhile
from pathlib import Path
from typing import Final, Literal, TypeAlias, final, get_args

from homebot.words.message_values import with_values
from homebot.words.tokens import Phrase, split_at

TextKind: TypeAlias = Literal["trigger", "condition", "step", "wish"]
BlockKind: TypeAlias = Literal["if", "if else", "times", "while", "until", "for each"]
OWN_LANGUAGES: Final = ("de", "fr", "it", "es", "nl")

_ENGLISH_BLOCKS: Final[Mapping[str, str]] = {
    "if": "if {if}: {do}",
    "if else": "if {if}: {do}, else: {else}",
    "times": "{n} times: {do} / repeat {n} times: {do}",
    "while": "repeat while {if}: {do}",
    "until": "repeat until {if}: {do}",
    "for each": "for each {x}: {do}",
    "numbers": "two / three / four / five / six / seven / eight / nine / ten / eleven / twelve",
    "and": " and ",
}
_BLOCK_KINDS: Final[Sequence[BlockKind]] = ("until", "while", "for each", "times", "if")
_SLOT_OF_BLOCK: Final = re.compile(r"\{(?:if|n|x)\}")
_MAX_CHARACTERS: Final = 300
"""Characters of a text in another language; as those of any text of a routine."""

_MIN_MARKS: Final = 2
_ALIKE: Final = 0.8
_SLOT: Final = re.compile(r"\{(\w)\}")
_VALUE: Final = re.compile(r"\{[^{}]*\}")
_AMOUNT: Final = re.compile(r"([+-]?\d++)(?:([.,])(\d++))?+ ?(\S*+)")
_LENGTHS: Final = re.compile(r"(?<!\d)(\d++(?:[.,]\d++)?+) ?([^\W\d_]++)")
_CLOCK: Final = re.compile(r"(\d{1,2})(?: ?[:.h] ?(\d\d)(?:[:h](\d\d))?)?(?: ?(?:uhr|uur|heures?|h))?", re.IGNORECASE)
_COLONS: Final = re.compile(r"(?<=\d):(?=\d\d\b)")
_ENGLISH_UNITS: Final = {
    spelling: unit
    for unit, name in (("s", "second"), ("m", "minute"), ("h", "hour"), ("d", "day"))
    for spelling in (unit, name, f"{name}s")
} | {"min": "m"}
_ENGLISH: Final = frozenset({"a", "do", "i", "lamp", "lamps", "minutes", "message", "of", "u", "was"})
"""English words, besides those of the forms, that another language has too."""

_LISTS_OF_SLOTS: Final = {"w": "none", "a": "every"}
_KINDS_OF_SLOTS: Final = {"t": "{t:length}", "l": "{l:length}", "n": "{n:number}"}
_QUOTES: Final = {'"': '"', "'": "'", "„": "“”", "“": "”", "«": "»"}
_ELISION: Final = "\N{RIGHT SINGLE QUOTATION MARK}"
"""The end of an elided word, such as an article before a vowel."""

_WORD_END: Final = re.compile(rf"[\s,:|]+|(?<={_ELISION})")
_ELIDED: Final = re.compile(rf"\b(\w{{1,7}})['{_ELISION}](?=\w)")


def to_english(text: str, kind: TextKind) -> str | None:
    """Return the English for *text*, which is in another language; None if it is in none of them."""
    return reading_of(text, kind)[1] or None


def language_of(text: str) -> str:
    """Return the language in which *text* is a trigger, condition, step or wish; empty if it is in none but English."""
    readings = (reading_of(text, kind) for kind in get_args(TextKind))
    return next((code for code, english in readings if english not in {"", text}), "")


@lru_cache(maxsize=2000)
def reading_of(text: str, kind: TextKind) -> tuple[str, str]:
    """Return the language of *text*, and its English; both are empty if it is in none of them."""
    if len(text) > _MAX_CHARACTERS:
        return "", ""
    readings = ((table.code, table.read(text, kind)) for table in _likely_tables(_words(text)))
    return next(((code, english) for code, english in readings if english), ("", ""))


@lru_cache(maxsize=2000)
def in_language(text: str, kind: TextKind, language: str) -> str:
    """Return *text* as *language* says it; as it is if it is in it already, or has no form there."""
    if len(text) > _MAX_CHARACTERS:
        return text
    if language not in OWN_LANGUAGES:
        return to_english(text, kind) or text
    table = _table(language)
    if not _words(text).isdisjoint(table.marks) and table.read(text, kind) not in {None, text}:
        return text
    return table.shown(to_english(text, kind) or text, kind) or text


def block_in_language(
    kind: BlockKind,
    language: str,
    do: Sequence[str],
    *,
    conditions: Sequence[str] = (),
    otherwise: Sequence[str] = (),
    times: int = 0,
    devices: str = "",
) -> str:
    """Return the sentence of a choice or loop as *language* says it, with texts that are in it already."""
    texts = _table(language).blocks if language in OWN_LANGUAGES else _ENGLISH_BLOCKS
    if language in OWN_LANGUAGES and devices:
        devices = _table(language).devices_out(devices)
    values = {"if": texts["and"].join(conditions), "do": "; ".join(do), "else": "; ".join(otherwise)}
    return texts[kind].split(" / ")[0].format(**values, n=times, x=devices)


def read_block(text: str) -> tuple[BlockKind, str, str, list[str], list[str]] | None:
    """Return a choice or loop that is written as a sentence of any language; None for any other text.

    Returns:
        Its kind, its conditions, devices or number of rounds, the word between conditions, its steps, and those of
        ``else``.
    """
    text, words = " ".join(text.split()).replace(" : ", ": "), _words(text)
    for blocks in (_ENGLISH_BLOCKS, *(table.blocks for table in _likely_tables(words))):
        joint = blocks["if else"].replace(" : ", ": ").partition("{do}")[2].removesuffix("{else}")
        for kind in _BLOCK_KINDS:
            for form in blocks[kind].replace(" : ", ": ").split(" / "):
                before, after = _SLOT_OF_BLOCK.split(form.removesuffix("{do}"))
                value, colon, do = text[len(before) :].partition(after)
                value = _number(value, blocks["numbers"].split(" / ")) if kind == "times" else value
                if not (text.casefold().startswith(before.casefold()) and colon and value and do):
                    continue
                do, _, otherwise = do.partition(joint) if kind == "if" else (do, "", "")
                return kind, value, blocks["and"].strip(), do.split("; "), otherwise.split("; ") if otherwise else []
    return None


def _number(text: str, words: Sequence[str]) -> str:
    """Return the digits of *text*, which may be one of the *words* for two, three and so on; empty for no number."""
    word = text.casefold()
    return str(words.index(word) + 2) if word in words else text if text.isdecimal() else ""


def split_wishes(text: str) -> list[str]:
    """Return the wishes of a goal *text*, which commas and the "and" of its language join.

    Raises:
        UsageError: It is too long.
    """
    english = split_at(text, "and", ",")  # or it is too long for the others, too
    splits = ((table, split_at(text, *table.joints, ",")) for table in _likely_tables(_words(text)))
    return next((parts for table, parts in splits if any(table.read(part, "wish") for part in parts)), english)


def devices_to_english(text: str) -> str:
    """Return the query *text* with the words for types in English, such as ``lights in Flur``."""
    return next(filter(None, (table.devices_in(text) for table in _likely_tables(_words(text)))), text)


def _likely_tables(words: frozenset[str]) -> list["_Table"]:
    """Return the tables with some of *words*, that with most of them first."""
    tables = [table for table in map(_table, OWN_LANGUAGES) if not words.isdisjoint(table.sure_marks)]
    return sorted(tables, key=lambda table: -len(table.sure_marks & words))


def hint_for(text: str, kind: TextKind) -> str:
    """Return how *text* could be written, in its language; empty if that is not known."""
    if len(text) > _MAX_CHARACTERS:
        return ""
    words = _words(text)
    table = max(map(_table, OWN_LANGUAGES), key=lambda one: len(one.sure_marks & words))
    return table.hint(text, kind) if len(table.sure_marks & words) >= _MIN_MARKS else ""


@cache
def _table(code: str) -> "_Table":
    table = json.loads((Path(__file__).parent / "languages" / f"{code}.json").read_text(encoding="utf-8"))
    return _Table(code, table, table["date"])


def _words(text: str) -> frozenset[str]:
    return frozenset(_WORD_END.split(text.casefold().replace("'", _ELISION)))


@final
class _Table:
    """The table of a language.

    Attributes:
        marks: Its words; a text without one of them is in another language.
        sure_marks: Those that are no English words.
        blocks: The sentences of choices and loops.
        joints: Its words for "and".
    """

    def __init__(self, code: str, table: Mapping[str, Mapping[str, str]], date: str) -> None:
        self.code = code
        self._forms = {kind: _rows(table[kind]) for kind in _SECTIONS}
        self._lists = {kind: _rows(table[kind]) for kind in _LISTS}
        self._meanings = {
            kind: {word.casefold(): key for key, words in rows.items() for word in words}
            for kind, rows in self._lists.items()
        }
        self.blocks = table["block"]
        self.joints = self._lists["words"]["and"]
        self._date = date
        self._awaited = table["awaited"]
        self._moved = table["moved"]
        self._hints = table["hints"]
        rows = chain.from_iterable(one.values() for one in (*self._forms.values(), *self._lists.values()))
        words = {word for text in chain.from_iterable(rows) for word in _WORD_END.split(text.casefold())}
        self.marks = frozenset(word.strip("[]") for word in words if "{" not in word and "}" not in word) - {""}
        english = {
            word for one in (self._forms, self._lists) for rows in one.values() for key in rows for word in key.split()
        }
        self.sure_marks = self.marks - english - _ENGLISH
        self._phrases: dict[str, list[tuple[str, _WordForm]]] = {}
        self._english: dict[str, list[tuple[str, _WordForm]]] = {}

    def read(self, text: str, kind: str) -> str | None:
        """Return the English for *text*; None if it has none of the forms."""
        return _around_values(text, lambda plain: self._read_parts(plain, kind), self.read)

    def _read_parts(self, text: str, kind: str) -> str | None:
        parts = [text] if kind in {"step", "value", "wish"} else split_at(text, *self._lists["words"]["or"])
        read = list(takewhile(bool, (self._read(part, kind) for part in parts)))  # one that is none ends it
        return self._read(text, kind) if len(read) < len(parts) else " or ".join(filter(None, read))

    def _read(self, text: str, kind: str) -> str | None:
        plain = _ELIDED.sub(self._split_elided, text)
        for form, moved in self._moved.items():
            plain = re.sub(form, moved, plain)
        plain = plain if kind == "step" else _COLONS.sub("h", plain)  # one token
        for word in self._lists["words"]["when"]:
            plain = plain[len(word) + 1 :] if plain.casefold().startswith(f"{word} ") else plain
        return self._first(self._phrases, plain, kind, self._in)

    def shown(self, english: str, kind: str) -> str | None:
        """Return the text for an *english* one; None if there is no form for it."""
        return _around_values(english, lambda plain: self._first(self._english, plain, kind, self._out), self.shown)

    def devices_in(self, text: str) -> str:
        """Return the query *text* in English; empty if it does not begin with one of the words for types."""
        named = (f"{own} " for kind in ("all", "some") for own in self._meanings[kind])
        return self._device_in(text, "all", "some") if f"{text.casefold()} ".startswith(tuple(named)) else ""

    def devices_out(self, text: str) -> str:
        """Return the English query *text* in this language."""
        return self._device_out(text, "all", "some")

    def hint(self, text: str, kind: TextKind) -> str:
        """Return how *text* could be written, in this language."""
        from difflib import get_close_matches  # noqa: PLC0415 - only after a mistake

        long = sorted(mark for mark in self.marks - self._meanings["months"].keys() if len(mark) > 4)
        for word in sorted(_words(text) - self.marks):
            if close := get_close_matches(word, long, 1, _ALIKE):
                return self._hints["meant"].format(text=text, word=word, close=close[0])
        return self._hints[kind].format(text=text)

    def _split_elided(self, found: re.Match[str]) -> str:
        """Return an elided word with a blank after it, so that an article is a word."""
        word = f"{found[1]}{_ELISION}"
        return f"{word} " if word.casefold() in self.marks else found[0]

    def _first(
        self,
        forms: dict[str, list[tuple[str, "_WordForm"]]],
        text: str,
        kind: str,
        translate: Callable[[str, str], str | None],
    ) -> str | None:
        if kind not in forms:
            compiled = self._compiled(kind, is_english=forms is self._english)
            forms[kind] = sorted(compiled, key=lambda row: row[1].begins_with_slot)
        words = _words(text)
        for written, form in forms[kind]:
            if (found := form.match(text, words)) is None:
                continue
            values = {slot: translate(slot, value) or "" for slot, value in found.items()}
            if all(values.values()):
                return written.format(**values).replace(" , ", ", ").replace(f"{_ELISION} ", "'")
        return None

    def _compiled(self, kind: str, *, is_english: bool) -> Iterator[tuple[str, "_WordForm"]]:
        for section in _SECTIONS_OF.get(kind, (kind,)):
            for english, own in self._forms[section].items():
                if is_english:
                    yield _spoken(own[0]), _WordForm(english)
                else:
                    forms = ((english, _WordForm(text)) for text in own)
                    yield from sorted(forms, key=lambda row: -row[1].words)

    def _in(self, slot: str, text: str) -> str | None:
        match slot:
            case "x" | "y":
                return self._device_in(text, "all", "some", every="all ")
            case "c":
                return self._device_in(text, "all")
            case "r":
                return self._plain(text)
            case "p" | "o" | "b":
                return text
            case "j":
                return text if text.isdecimal() else None
            case "g":
                return self.read(text, "trigger") or text
            case "e" | "f":
                return self._date_in(text)
            case "t" | "l":
                return self._length(text)
            case "h" | "k":
                plain = self._plain(text)
                known = self._meanings["sun"].get(plain.casefold()) or _clock(plain)
                return known or self._first(self._phrases, text, "moment", self._in)
            case "u":
                return self._meanings["sun"].get(self._plain(text).casefold())
            case "d":
                return self._days_in(text)
            case "n":
                return self._amount(text, ".", self._meanings["amounts"])
            case "v" | "q" | "w" | "a":
                meanings = self._meanings[_LISTS_OF_SLOTS.get(slot, "values")]
                return meanings.get(text.casefold()) or meanings.get(self._plain(text).casefold())
            case "s" | "i":
                return self.read(text, "state")
        return _unquoted(text)

    def _out(self, slot: str, text: str) -> str | None:
        match slot:
            case "x" | "y":
                return self._device_out(text, "some", "plurals")
            case "c":
                return self._device_out(text.removesuffix(" to"), "all")
            case "r" | "p" | "o" | "b":
                return text
            case "j":
                return text if text.isdecimal() else None
            case "g":
                parts = [self.shown(part, "trigger") or part for part in split_at(text, "or")]
                return f" {self._lists['words']['or'][0]} ".join(parts)
            case "e" | "f":
                return self._date_out(text)
            case "t" | "l":
                return self._length(text, self._lists["units"])
            case "h" | "k" | "u":
                found = self._lists["sun"].get(text.casefold())
                if found or slot == "u":
                    return found[0] if found else None
                return _clock(text) if ":" in text else self._first(self._english, text, "moment", self._out)
            case "d":
                return self._days_out(text)
            case "n":
                return self._amount(text, ",", {})
            case "v" | "q" | "w" | "a":
                rows = self._lists[_LISTS_OF_SLOTS.get(slot, "values")]
                return next(iter(rows.get(text.casefold(), ())), None)
            case "s" | "i":
                words = (self.shown(text, "state") or "").split(" ")
                last = next((at for at in reversed(range(len(words))) if self._awaited.get(words[at]) == ""), None)
                words += [] if last is None else [words.pop(last)]
                return " ".join(self._awaited.get(word) or word for word in words)
        return f'"{_unquoted(text)}"'

    def _plain(self, text: str) -> str:
        """Return *text* without the articles before it."""
        words = text.split(" ")
        while len(words) > 1 and words[0].casefold() in self._lists["words"]["the"]:
            words = words[1:]
        return " ".join(words)

    def _device_in(self, text: str, *kinds: str, every: str = "") -> str:
        """Return *text* without its article; types are translated only after words such as "all", since names stay.

        Args:
            every: What stands before all of a type.
        """
        if text[:1] in _QUOTES:
            return text
        if (pronoun := self._meanings["it"].get(text.casefold())) is not None:
            return pronoun
        places = self._lists["words"]["in"]
        for kind in (*kinds, "plurals"):
            spoken = self._plain(text) if kind == "plurals" else text
            for own, english in self._meanings[kind].items():
                if f"{spoken.casefold()} ".startswith(f"{own} "):
                    rest, of_types = spoken[len(own) :], [*places, *self._lists["words"]["of"]]
                    if kind != "plurals" or not rest or rest.split()[0].casefold() in of_types:  # else a name
                        return f"{every if kind == 'all' else ''}{english}{self._with_place(rest, of_types)}"
        return self._with_place(self._plain(text), places)

    def _with_place(self, text: str, places: Sequence[str]) -> str:
        head, *words = text.split(" ")
        articles = self._lists["words"]["the"]
        kept = [head]
        for word in words:
            if word.casefold() in places:
                kept.append("in")
            elif kept[-1] != "in" or word.casefold() not in articles:
                kept.append(word)
        return " ".join(kept)

    def _device_out(self, text: str, *kinds: str) -> str:
        if text in self._lists["it"]:
            return self._lists["it"][text][0]
        first, *rest = text.removeprefix("the ").removeprefix("all " if "all" in kinds else "").split(" ")
        own = next((self._lists[kind][first][0] for kind in kinds if first in self._lists[kind]), first)
        is_type = not rest or rest[0] == "in"
        place = self._lists["words"]["in"][0]
        return " ".join([own if is_type else first, *(place if word == "in" else word for word in rest)])

    def _length(self, text: str, shown: Mapping[str, list[str]] | None = None) -> str | None:
        if _LENGTHS.sub("", text).strip(" ."):
            return None
        pieces = []
        for number, name in _LENGTHS.findall(text):
            unit = self._meanings["units"].get(name.casefold()) or _ENGLISH_UNITS.get(name.casefold())
            if unit is None:
                return None
            if shown is None:
                pieces.append(f"{number.replace(',', '.')}{unit}")
            else:
                pieces.append(f"{number.replace('.', ',')} {shown[unit][number != '1']}")
        return ("" if shown is None else " ").join(pieces) or None

    def _amount(self, text: str, point: str, units: Mapping[str, str]) -> str | None:
        if (found := _AMOUNT.fullmatch(text)) is None:
            return None
        whole, _, fraction, unit = found.groups()
        number = f"{whole}{point}{fraction}" if fraction else whole
        return f"{number} {units.get(unit.casefold(), unit)}".strip()

    def _date_in(self, text: str) -> str | None:
        """Return ``24 december`` for a day of the year, ``december`` for a month; None for none."""
        *words, month = self._plain(text).casefold().replace(".", " ").split()
        english = self._meanings["months"].get(month)
        numbers = [word.rstrip("erº") for word in words if word not in self._lists["words"]["of"]]
        if english is None or len(numbers) > 1 or not all(number.isdecimal() for number in numbers):
            return None
        return " ".join((*numbers, english))

    def _date_out(self, text: str) -> str | None:
        words = text.casefold().replace(".", " ").split()
        months = [own for name, own in self._lists["months"].items() if any(name.startswith(word) for word in words)]
        numbers = [word for word in words if word.isdecimal()]
        if len(months) != 1 or len(words) != len(numbers) + 1 or len(numbers) > 1:
            return None
        return self._date.format(day=numbers[0], month=months[0][0]) if numbers else months[0][0]

    def _days_in(self, text: str) -> str | None:
        if whole := self._meanings["days"].get(text.casefold()):
            return whole
        days = [
            self._range(part, self._lists["words"]["to"]) for part in split_at(text, ",", *self._lists["words"]["and"])
        ]
        return ",".join(filter(None, days)) if None not in days else None

    def _range(self, text: str, words: list[str]) -> str | None:
        ends = [self._meanings["days"].get(self._plain(end).casefold()) for end in split_at(text, *words)]
        return "-".join(filter(None, ends)) if None not in ends else None

    def _days_out(self, text: str) -> str | None:
        parts = [self._lists["days"].get(part.strip()) for part in re.split(r"[,-]", text.casefold())]
        joint = self._lists["words"]["to" if "-" in text else "and"][0]
        return f" {joint} ".join(part[0] for part in parts if part) if None not in parts else None


@final
class _WordForm:
    """A form of words, which is tried only on texts with its words.

    Attributes:
        words: How many words it needs; forms with more are tried first.
    """

    def __init__(self, text: str) -> None:
        self._phrase = Phrase(_SLOT.sub(lambda slot: _KINDS_OF_SLOTS.get(slot[1], slot[0]), text.casefold()))
        words = [word for word in text.casefold().split() if word[0] not in "{[" and word != ","]
        self._needed = [frozenset(word.split("|")) for word in words]
        self.words = len(words)
        self.begins_with_slot = text[0] == "{"

    def match(self, text: str, words: frozenset[str]) -> Mapping[str, str] | None:
        """Return the values of the slots in *text*, which has *words*; None if it has another form."""
        if any(words.isdisjoint(needed) for needed in self._needed):
            return None
        return self._phrase.match(text)


_SECTIONS: Final = ("state", "moment", "trigger", "condition", "step", "value", "wish", "place")
_SECTIONS_OF: Final[Mapping[str, Sequence[str]]] = {
    "trigger": ("moment", "trigger", "state"),
    "condition": ("state", "condition"),
    "wish": ("wish", "state", "step", "place"),
}
_LISTS: Final = (
    "words",
    "units",
    "amounts",
    "days",
    "months",
    "sun",
    "values",
    "it",
    "some",
    "all",
    "plurals",
    "every",
    "none",
)


def _rows(table: Mapping[str, str]) -> dict[str, list[str]]:
    return {key: row.replace("'", _ELISION).split(" / ") for key, row in table.items()}


def _spoken(text: str) -> str:
    """Return the form *text* with the first of its words, and without those that may be missing."""
    return " ".join(word.split("|")[0] for word in text.split() if not word.startswith("["))


def _clock(text: str) -> str | None:
    found = _CLOCK.fullmatch(text)
    return None if found is None else ":".join((found[1], found[2] or "00", *filter(None, (found[3],))))


def _around_values(
    text: str, translate: Callable[[str], str | None], of_value: Callable[[str, str], str | None]
) -> str | None:
    """Return *text* as *translate* has it with numbers in the places of values in braces, and these as *of_value*."""
    values = _VALUE.findall(text)
    mark = "7"
    while values and mark in text:
        mark += "7"
    numbers = [f"{mark}{number:03}" for number in range(len(values))]
    left = iter(numbers)
    translated = translate(_VALUE.sub(lambda _: next(left), text))
    for number, value in zip(numbers, values, strict=True) if translated else ():
        own = with_values(value, lambda operand: of_value(operand, "value") or operand)
        translated = (translated or "").replace(number, own)
    return translated


def _unquoted(text: str) -> str:
    return text[1:-1].strip() if text[-1:] in tuple(_QUOTES.get(text[:1], "")) and len(text) > 1 else text
