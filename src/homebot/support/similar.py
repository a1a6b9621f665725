"""Suggestions for misspelt names. Pure."""

from collections.abc import Iterable

from homebot.support.folding import fold

_CUTOFF = 0.5
_MAX_SUGGESTIONS = 3


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
