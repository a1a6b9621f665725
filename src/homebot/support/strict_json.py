"""Unambiguous JSON: without duplicate keys, which programs treat differently, and in ASCII. Pure."""

import codecs
import json
from collections.abc import Callable
from typing import Any

_ESCAPE = "homebot.json"


class DuplicateKeyError(ValueError):
    """A JSON object with a duplicate key."""


def parse_strict(text: str | bytes, constant: Callable[[str], object] = float) -> object:
    """Parse *text*.

    Args:
        constant: Returns the value of ``NaN``, ``Infinity`` and ``-Infinity``, which are not valid JSON.

    Raises:
        DuplicateKeyError: An object has a duplicate key.
        ValueError: It is not JSON.
        RecursionError: It is nested too deeply.
    """
    value: object = json.loads(text, object_pairs_hook=_reject_duplicates, parse_constant=constant)
    return value


def in_ascii(text: str) -> str:
    """Return JSON *text*, as written by the module `json`, with everything but visible ASCII and blanks escaped.

    This includes C1 control characters and lone surrogates.
    """
    plain = text if text.isascii() else text.encode("ascii", _ESCAPE).decode()
    return plain.replace("\x7f", "\\u007f")


def duplicate_key_hook(note: Callable[[str], None]) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    """Return a hook that builds objects and calls *note* with each duplicate key; the last value counts.

    For `json.JSONDecoder`, as ``object_pairs_hook``.
    """

    def build_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        built = dict(pairs)
        if len(built) < len(pairs):
            note(_report_repeated(pairs))
        return built

    return build_object


def _reject(key: str) -> None:
    raise DuplicateKeyError(f"the key {key[:60]!r} occurs twice")


_reject_duplicates = duplicate_key_hook(_reject)


def _report_repeated(pairs: list[tuple[str, Any]]) -> str:
    seen: set[str] = set()
    for key, _ in pairs:
        if key in seen:
            return key
        seen.add(key)
    return ""


def _escape(error: UnicodeError) -> tuple[str, int]:
    """Return the escapes of non-ASCII characters and the position after them."""
    assert isinstance(error, UnicodeEncodeError)  # noqa: S101 - for the type checker
    return json.dumps(error.object[error.start : error.end])[1:-1], error.end


codecs.register_error(_ESCAPE, _escape)
