"""Names and lists of names, as rosapi's clients write and expect them."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["absolute", "unique"]


def absolute(name: str) -> str:
    """Return *name* with the leading slash that some clients leave out."""
    return name if name.startswith("/") else f"/{name}"


def unique(names: Iterable[str]) -> tuple[str, ...]:
    """Return *names* sorted, each once."""
    return tuple(sorted(set(names)))
