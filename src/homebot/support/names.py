"""Names that people write, of a device, person, robot, room, group, scene or routine. Pure.

A name is the whole name without regard to case and accents; a similar one is a suggestion, and never the answer.
"""

from collections.abc import Iterable
from typing import Final

from homebot.errors import UsageError
from homebot.support.folding import fold

ARTICLES: Final = ("the", "a", "an", "my")

CLOSE: Final = 0.8
"""How similar a name must be to be suggested for a text that may also be other words."""

_QUOTES: Final = "\"'"

_CUTOFF = 0.5
_MAX_SUGGESTIONS = 3


def spellings(text: str) -> tuple[str, ...]:
    """Return the names that *text* may be, the most literal first: all of it, without quotes, without an article."""
    whole = text.strip()
    plain = whole[1:-1] if whole[:1] in _QUOTES and whole[1:].endswith(whole[:1]) else whole.strip('"')
    article, _, name = plain.partition(" ")
    bare = name.strip(' "') if article.casefold() in ARTICLES else plain
    return tuple(dict.fromkeys(filter(None, (whole, plain, bare))))


def find_name(text: str, names: Iterable[str]) -> str:
    """Return the first of *names* that *text* is, perhaps in quotes or after an article; empty for none."""
    known: dict[str, str] = {}
    for name in names:
        known.setdefault(fold(name), name)
    return next((known[name] for name in map(fold, spellings(text)) if name in known), "")


def resolve_name(kind: str, text: str, names: Iterable[str], otherwise: str = "") -> str:
    """Return the name by :func:`find_name`.

    Args:
        kind: What is named, such as ``room``.
        otherwise: The advice if none is similar; by default all are listed.

    Raises:
        UsageError: There is none; similar ones are suggested.
    """
    names = [*names]
    if name := find_name(text, names):
        return name
    raise UsageError(no_such(kind, text, names, otherwise))


def no_such(kind: str, text: str, names: Iterable[str], otherwise: str = "") -> str:
    """Return the error text for a name that nothing has; see :func:`resolve_name`."""
    known = [*dict.fromkeys(names)]
    hint = did_you_mean(text, known, otherwise or f"{kind}s are {', '.join(known) or 'none'}")
    return f"there is no {kind} {text!r}; {hint}"


def close_names(text: str, names: Iterable[str], otherwise: str) -> str:
    """Return ``did you mean …?`` if one of *names* is close to *text*, or else *otherwise*."""
    return did_you_mean(spellings(text)[-1], names, otherwise, CLOSE)


def similar_to(name: str, known: Iterable[str], cutoff: float = _CUTOFF) -> list[str]:
    """Return up to three *known* names similar to *name*, best first.

    Case and accents are ignored.

    Args:
        cutoff: Least similarity, from 0 to 1.
    """
    from difflib import get_close_matches  # noqa: PLC0415 - only after a mistake

    wanted = fold(str(name))  # perhaps from an app, which may pass anything
    names = {fold(known_name): known_name for known_name in sorted(set(known), reverse=True)}
    matches = get_close_matches(wanted, names, n=_MAX_SUGGESTIONS, cutoff=cutoff)
    return [
        names[match]
        for match in matches
        or sorted(known_name for known_name in names if wanted and wanted.strip("/") in known_name)[:_MAX_SUGGESTIONS]
    ]


def did_you_mean(name: str, known: Iterable[str], otherwise: str, cutoff: float = _CUTOFF) -> str:
    """Return ``did you mean …?`` if a *known* name is similar to *name*, or else *otherwise*."""
    similar = similar_to(name, known, cutoff)
    return f"did you mean {' or '.join(similar)}?" if similar else otherwise


def unknown_key(name: str, known: Iterable[str]) -> str:
    """Return the error text for the unknown key *name* of a table."""
    keys = [*known]
    all_known = f"known are {', '.join(keys) or 'none'}"
    return f"unknown key; {did_you_mean(name, keys, all_known)}"
