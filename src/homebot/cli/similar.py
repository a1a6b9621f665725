"""Names that somebody may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

__all__ = ["not_found"]


def not_found(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the sentence that there is no *kind* called *name*, and which of the *known* ones are similar."""
    names = sorted(set(known))
    similar = get_close_matches(name, names, n=3, cutoff=0.5) or [one for one in names if name.strip("/") in one][:3]
    hint = f"did you mean {' or '.join(similar)}?" if similar else f"`homebot {kind} list` shows what there is"
    return f"there is no {kind} {name}; {hint}"
