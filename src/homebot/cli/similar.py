"""The answer to a name that there is none of."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.similar import did_you_mean

__all__ = ["not_found"]


def not_found(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the sentence that there is no *kind* called *name*, and which of the *known* ones are similar."""
    return f"there is no {kind} {name}; {did_you_mean(name, known, f'`homebot {kind} list` lists all')}"
