"""Fields of automations. Pure.

All functions of this package raise :class:`NotCarriedError` for what no routine can do, or homebot does not know.
"""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Final

from homebot.errors import UsageError
from homebot.support.located import Located

__all__ = [
    "NotCarriedError",
    "check_keys",
    "check_tag",
    "duration_of",
    "fields_of",
    "flag_of",
    "is_enabled",
    "items_of",
    "limits_of",
    "needed",
    "number_of",
    "shown",
    "text_of",
    "texts_of",
    "walk",
]

_TEMPLATE: Final = ("{{", "{%", "{#")
_CLOCK: Final = re.compile(r"(?P<sign>[+-]?)(?P<hours>\d+):(?P<minutes>\d{1,2})(?::(?P<seconds>\d{1,2}))?")
_EITHER: Final = re.compile(r"[+-]?[1-9]\d*:\d\d?")
"""Without quotation marks YAML 1.1, which Home Assistant reads, has 5:00 as a number to the base of 60."""

_UNITS: Final = {"days": 86_400, "hours": 3600, "minutes": 60, "seconds": 1}
_NO: Final = frozenset({"false", "no", "off", "disable"})
_YES: Final = frozenset({"true", "yes", "on", "enable"})
_LONGEST: Final = 60


class NotCarriedError(UsageError):
    """A part of an automation without counterpart; the message names it, with the reason."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(problem)
        self.line = line


def fields_of(node: Located, what: str) -> dict[str, Located]:
    """Return the fields of a mapping."""
    check_tag(node)
    if not isinstance(node.value, dict):
        raise NotCarriedError(node.line, f"{what}: {shown(node)} is not a mapping")
    return node.value


def items_of(node: Located | None) -> list[Located]:
    """Return the elements of a list, or a value that stands for a list of one."""
    if node is None:
        return []
    check_tag(node)
    if isinstance(node.value, list):
        return [one for item in node.value for one in items_of(item)]
    return [] if node.value is None else [node]


def check_tag(node: Located) -> None:
    """Check that *node* is written in this file."""
    if node.tag:
        raise NotCarriedError(node.line, f"{node.tag} {shown(node)}: write the value itself there")


def text_of(node: Located, what: str) -> str:
    """Return a text or a number as text."""
    check_tag(node)
    value = node.value
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise NotCarriedError(node.line, f"{what}: {shown(node)} is not a text")
    text = str(value).strip()
    if any(one in text for one in _TEMPLATE):
        raise NotCarriedError(node.line, f"{what}: a template, {shown(node)}; routines have none")
    return text


def texts_of(node: Located, what: str) -> list[str]:
    """Return a list of texts, or a text with commas, as Home Assistant reads ids of entities."""
    return [part.strip() for one in items_of(node) for part in text_of(one, what).split(",") if part.strip()]


def number_of(node: Located, what: str) -> float:
    """Return a number."""
    text = text_of(node, what)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise NotCarriedError(node.line, f"{what}: {shown(node)} is not a number")
    return number


def needed(node: Located, fields: Mapping[str, Located], key: str) -> Located:
    """Return the field *key* of *node*."""
    if key not in fields:
        raise NotCarriedError(node.line, f"`{key}` is missing")
    return fields[key]


def limits_of(node: Located, fields: Mapping[str, Located]) -> tuple[float | None, float | None]:
    """Return the limits ``above`` and ``below`` of a number."""
    above, below = (number_of(fields[one], one) if one in fields else None for one in ("above", "below"))
    if above is None and below is None:
        raise NotCarriedError(node.line, "`above` or `below` is missing")
    return above, below


def is_enabled(fields: Mapping[str, Located]) -> bool:
    """Return whether the part with *fields* counts."""
    if (node := fields.get("enabled")) is None:
        return True
    return flag_of(node, "enabled")


def flag_of(node: Located, what: str) -> bool:
    """Return a truth value, also as YAML 1.1 spells it: ``off`` and ``no``."""
    word = str(node.value).casefold()
    if word in _NO or word in _YES:
        return word in _YES
    raise NotCarriedError(node.line, f"{what}: {shown(node)} is neither true nor false")


def duration_of(node: Located, what: str) -> str:
    """Return a length of time as homebot spells it, with its sign: ``5m``; empty for none."""
    seconds = _seconds_of(node, what)
    parts, rest = [], abs(seconds)
    for unit, length in (("h", 3600), ("m", 60)):
        count, rest = divmod(rest, length)
        parts += [f"{count:.0f}{unit}"] if count else []
    parts += [f"{rest:g}s"] if rest else []
    return ("-" if seconds < 0 else "") + "".join(parts)


def _seconds_of(node: Located, what: str) -> float:
    if isinstance(node.value, dict):
        fields = fields_of(node, what)
        check_keys(node, what, *_UNITS)
        return sum(number_of(one, f"{what}: {unit}") * _UNITS[unit] for unit, one in fields.items())
    text = text_of(node, what)
    if _EITHER.fullmatch(text):
        raise NotCarriedError(node.line, f"{what}: {text} may be minutes or hours; write it as hh:mm:ss")
    if (clock := _CLOCK.fullmatch(text)) is not None:
        hours, minutes, seconds = (int(clock[one] or 0) for one in ("hours", "minutes", "seconds"))
        return (-1 if clock["sign"] == "-" else 1) * (3600 * hours + 60 * minutes + seconds)
    return number_of(node, what)


def check_keys(node: Located, what: str, *known: str) -> None:
    """Check that *node* has no field beside the *known* ones, as it would be lost."""
    for key, value in fields_of(node, what).items():
        if key not in known:
            raise NotCarriedError(value.line, f"{what}: `{key}` has no counterpart in routines")


def shown(node: Located) -> str:
    """Return a value for a message."""
    text = repr(_plain(node))
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _plain(node: Located) -> object:
    if isinstance(node.value, dict):
        return {key: _plain(one) for key, one in node.value.items()}
    return [_plain(one) for one in node.value] if isinstance(node.value, list) else node.value


def walk(node: Located) -> Iterator[dict[str, Located]]:
    """Yield all mappings in *node*."""
    if isinstance(node.value, dict):
        yield node.value
    for one in (
        node.value.values() if isinstance(node.value, dict) else node.value if isinstance(node.value, list) else ()
    ):
        yield from walk(one)
