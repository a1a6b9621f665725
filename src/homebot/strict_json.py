"""JSON without ambiguity: a key that is there twice is refused, for programs disagree on which one counts. Pure."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

__all__ = ["DuplicateKeyError", "object_noting", "parse_strict"]


class DuplicateKeyError(ValueError):
    """A JSON object has a key twice."""


def parse_strict(text: str | bytes) -> object:
    """Return what *text* spells.

    Raises:
        DuplicateKeyError: A key is there twice.
        ValueError: It is no JSON.
        RecursionError: It is nested too deep.
    """
    value: object = json.loads(text, object_pairs_hook=_only_once)
    return value


def object_noting(note: Callable[[str], None]) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    """Return what makes objects of pairs and calls *note* with each key that is there again; the last one counts.

    It is for :class:`json.JSONDecoder`, as ``object_pairs_hook``.
    """

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            note(_repeated(pairs))
        return found

    return made


def _only_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise DuplicateKeyError(f"the key {_repeated(pairs)[:60]!r} is there twice")
    return found


def _repeated(pairs: list[tuple[str, Any]]) -> str:
    seen: set[str] = set()
    for key, _ in pairs:
        if key in seen:
            return key
        seen.add(key)
    return ""
