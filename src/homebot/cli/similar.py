"""Names that somebody may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

__all__ = ["not_found", "similar_to"]


def not_found(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the sentence that there is no *kind* called *name*, and which of the *known* ones are similar."""
    similar = similar_to(name, known)
    hint = f"did you mean {' or '.join(similar)}?" if similar else f"`homebot {kind} list` shows what there is"
    return f"there is no {kind} {name}; {hint}"


def similar_to(name: str, known: Iterable[str]) -> list[str]:
    """Return up to three of the *known* names that somebody may have meant by *name*."""
    names = sorted(set(known))
    return get_close_matches(name, names, n=3, cutoff=0.5) or [one for one in names if name.strip("/") in one][:3]
