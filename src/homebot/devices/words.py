"""Words in names and models of devices that reveal the load of a part: the table ``words.json``, by language. Pure.

The words of the table are in lower case without accents, see :mod:`homebot.support.folding`. Its groups:

- ``heat``: loads that burn or scald. Of heaters, only those that blow, glow or radiate: their manuals
(IEC 60335-2-30) forbid switching them by a timer or remotely, because they may be covered.
- ``fire``: loads in which a fire burns.
- ``water``: loads that flood, or keep water out, and valves of gas. ``entry``: gates, doors, bolts.
- ``lock``: locks.
- ``opener``: drives of a door or a gate. ``open``: commands that let in, disarm, or start an engine.
- ``machine``: parts by which an oven or a car is known.
- ``siren``: loads that sound. They do not always ask, but are not loads like others.
- ``garage``: places whose cover is a door if this is its whole name.
- ``window``: drives of a window.
- ``covering``: covers of windows. ``lamp``: lamps. These are harmless.

An entry is a phrase of one or more words in any order, the end of a word, ``-ventil``, or any part of it, ``-阀-``, for
languages that write no blanks. Besides the groups:

- ``at_end``: a phrase counts only as the end of a name or of one of its ``clauses``, as in English: ``Gate motor 2``,
  ``Valve of the garden``. ``fillers`` after it are ignored. ``never``: phrases that do not count at the end of a name.
- ``beside``: ends of words for things next to such a load. A name with one of them does not count.
- ``opens`` and ``objects``: each of the first with each of the second is a phrase of ``open``.

Source of the words for to lock, unlock, open and disarm: the actions and states of ``lock``, ``cover``, ``valve`` and
``alarm_control_panel`` in Home Assistant core, ``components/NAME/translations/LANGUAGE.json``.
"""

import json
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from itertools import chain, pairwise, product, repeat
from pathlib import Path
from string import ascii_lowercase, ascii_uppercase
from typing import Final, NamedTuple, TypeAlias

from homebot.support.folding import words_of

Groups: TypeAlias = frozenset[str]

COVERING: Final = frozenset({"covering"})
GARAGE: Final = frozenset({"garage"})
LAMP: Final = frozenset({"lamp"})
MACHINE: Final = frozenset({"machine"})
FIRE: Final = frozenset({"fire"})
HEAT: Final = frozenset({"heat", "fire"})
OPEN: Final = frozenset({"open"})
OPENER: Final = frozenset({"opener"})
SIREN: Final = frozenset({"siren"})
WATER: Final = frozenset({"water"})
WINDOW: Final = frozenset({"window"})
BURNS_OR_FLOODS: Final = HEAT | WATER
NO_LOCK: Final = BURNS_OR_FLOODS | {"entry", "opener", "open"}
"""The groups of parts that always ask, except locks: a lock among settings is a key lock."""

ALL_THAT_ASK: Final = NO_LOCK | {"lock"}

_GROUPS: Final = ALL_THAT_ASK | SIREN | GARAGE | WINDOW | COVERING | LAMP | MACHINE
_DIGITS: Final = "0123456789"


class _Phrase(NamedTuple):
    words: frozenset[str]
    group: str
    content: frozenset[str]
    """Its words, without fillers."""
    rarest: str
    """The one of its words that fewest phrases of its language have: ``heat`` of ``heat lamp``."""


class _Language(NamedTuple):
    phrases: tuple[_Phrase, ...]
    endings: tuple[tuple[str, str], ...]
    beside: tuple[str, ...]
    never: frozenset[frozenset[str]]
    fillers: frozenset[str]
    clauses: frozenset[str]
    at_end: bool


@lru_cache(maxsize=4096)
def matching_words(text: str, groups: Groups, *, anywhere: bool = False) -> str:
    """Return the words in *text* that indicate something of *groups*; empty if there are none.

    A name with capitals is read as one word, ``WarmWasser``, and as several, ``OpenGate``.

    Args:
        anywhere: Whether the position of the words in *text* does not matter.
    """
    matched = _matching_words(text, groups, anywhere=anywhere)
    if matched or text.islower():
        return matched
    ends = [
        place
        for place, pair in enumerate(pairwise(text), 1)
        if pair[0] in ascii_lowercase and pair[1] in ascii_uppercase
    ]
    if not ends:
        return ""
    apart = " ".join(text[begin:end] for begin, end in pairwise((0, *ends, len(text))))
    return _matching_words(apart, groups, anywhere=anywhere)


def _matching_words(text: str, groups: Groups, *, anywhere: bool) -> str:
    words = tuple([word.rstrip(_DIGITS) for word in words_of(text) if not word.isdigit()])
    numbers = set(chain.from_iterable(map(_languages_of, words, repeat(groups))))
    for language in map(_LANGUAGES.__getitem__, sorted(numbers)):
        for clause in _clauses(words, language):
            if matched := _match(clause, language, groups, at_end=language.at_end and not anywhere):
                return matched
    return ""


@lru_cache(maxsize=8192)
def _languages_of(word: str, groups: Groups) -> tuple[int, ...]:
    """Return the numbers of the languages in which a name with *word* may indicate something of *groups*.

    Names of a house repeat few words, and most words are of none.
    """
    if not _is_sign(word, groups, None):
        return ()
    return tuple(number for number in range(len(_LANGUAGES)) if _is_sign(word, groups, number))


def _is_sign(word: str, groups: Groups, number: int | None) -> bool:
    vocabulary, ends, pieces, ascii_pieces = _signs(groups, number)
    return (
        word in vocabulary
        or word.endswith(ends)
        or any(map(word.__contains__, ascii_pieces if word.isascii() else pieces))
    )


@lru_cache(maxsize=1024)
def _signs(
    groups: Groups, number: int | None
) -> tuple[frozenset[str], tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return the rarest words of phrases, the ends, the pieces, and the pieces in ASCII, of words of *groups*.

    They are those of the language with *number*, or of all.
    """
    languages = _LANGUAGES if number is None else _LANGUAGES[number : number + 1]
    words = frozenset(phrase.rarest for language in languages for phrase in language.phrases if phrase.group in groups)
    endings = [ending for language in languages for ending, group in language.endings if group in groups]
    pieces = tuple(ending for ending in endings if not ending.endswith("$"))
    ends = tuple(ending[:-1] for ending in endings if ending.endswith("$"))
    return words, ends, pieces, tuple(filter(str.isascii, pieces))


def _clauses(words: tuple[str, ...], language: _Language) -> Iterator[tuple[str, ...]]:
    yield words
    start = 0
    for number, word in enumerate(words):
        if word in language.clauses:
            yield words[start:number]
            start = number + 1


def _match(words: tuple[str, ...], language: _Language, groups: Groups, *, at_end: bool) -> str:
    if language.beside and _is_beside(words, language):
        return ""
    content = tuple(word for word in words if word not in language.fillers)
    if any(frozenset(tail[-len(phrase) :]) == phrase for phrase in language.never for tail in (words, content)):
        return ""
    return _phrase_in(words, content if at_end else None, language, groups) or _ending_in(words, language, groups)


def _is_beside(words: tuple[str, ...], language: _Language) -> bool:
    own = tuple(ending[:-1] for ending, _ in language.endings if ending.endswith("$"))
    return any(word.endswith(language.beside) and not word.endswith(own) for word in words)


def _phrase_in(words: tuple[str, ...], head_of: tuple[str, ...] | None, language: _Language, groups: Groups) -> str:
    """Return the words of the first phrase in *words*, which must be at the end of *head_of* if given."""
    known = frozenset(words)
    for phrase in language.phrases:
        if phrase.words <= known and phrase.group in groups and (head_of is None or _is_head(phrase, head_of)):
            return " ".join(word for word in words if word in phrase.words)
    return ""


def _ending_in(words: tuple[str, ...], language: _Language, groups: Groups) -> str:
    for ending, group in language.endings:
        if group in groups and (matched := next((word for word in words if ending in f"{word}$"), "")):
            return matched
    return ""


def _is_head(phrase: _Phrase, content: tuple[str, ...]) -> bool:
    """Return whether *phrase* ends *content*; a single opening word may also begin it: ``Disarm the house``."""
    size = len(phrase.content)
    is_end = frozenset(content[-size:]) == phrase.content
    return is_end or (phrase.group == "open" and len(phrase.words) == 1 and content[:1] == (*phrase.words,))


def _read_tables() -> tuple[_Language, ...]:
    tables = json.loads(Path(__file__).with_name("words.json").read_text(encoding="utf-8")).values()
    beside = tuple(word for table in tables for word in table.get("beside", ()))  # people mix languages
    return tuple(_language(table, () if table.get("at_end") else beside) for table in tables)


def _language(table: dict[str, list[str]], beside: tuple[str, ...]) -> _Language:
    fillers = frozenset(table.get("fillers", ()))
    entries = [(entry, group) for group in sorted(_GROUPS) for entry in table.get(group, ())]
    pairs = product(table.get("opens", ()), table.get("objects", ()))
    entries += [(f"{verb} {thing}", "open") for verb, thing in pairs]
    words = [(frozenset(entry.split()), group) for entry, group in entries if not entry.startswith("-")]
    counts = Counter(chain.from_iterable(phrase for phrase, _ in words))
    rarest = [min(phrase, key=lambda word: (counts[word], word)) for phrase, _ in words]
    return _Language(
        tuple(_Phrase(*row, row[0] - fillers, rare) for row, rare in zip(words, rarest, strict=True)),
        tuple((f"{entry[1:]}$".replace("-$", ""), group) for entry, group in entries if entry.startswith("-")),
        beside,
        frozenset(frozenset(entry.split()) for entry in table.get("never", ())),
        fillers,
        frozenset(table.get("clauses", ())),
        bool(table.get("at_end")),
    )


_LANGUAGES = _read_tables()
