"""Changes of a file of TOML as its owner would write them: comments, order and blanks stay. Pure.

tomlkit (0.15) takes the comment above a table for the end of the one before: it goes or parts with its table.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from typing import Any, Final, cast

from homebot.errors import UsageError
from homebot.support.toml_lines import line_of
from homebot.support.toml_text import toml_value

REMOVED = object()
"""In place of a value: the key is taken out."""

_CODE: Final = re.compile(
    r"(?>[^#\"'\n]"
    r'|"""(?:\\.|[^\\])*?"""|"(?:\\.|[^"\\\n])*"'
    r"|'''.*?'''|'[^'\n]*')*+"
)
"""A line before its comment; each text in it is read once."""


def edit_toml(text: str, table: tuple[str, ...], values: Mapping[str, object]) -> str:
    """Return *text* with *values* in *table*, which is appended if it is not there; :data:`REMOVED` takes a key out.

    Raises:
        UsageError: A value stands where only a person can change it, such as on several lines.
    """
    for key, value in values.items() or [("", REMOVED)]:
        text = _edit(text, table, key, value)
    return text


def _edit(text: str, table: tuple[str, ...], key: str, value: object) -> str:
    before = tomllib.loads(text)
    wanted = deepcopy(dict(before))
    here: Any = wanted
    for name in table:
        here = here.setdefault(name, {})
        if not isinstance(here, dict):
            raise UsageError(f"{name} of [{'.'.join(table)}] is no table, but a value or several tables")
    if value is REMOVED:
        here.pop(key, None)
    else:
        here[key] = value
    if wanted == before:
        return text
    bare = {name: own for name, own in wanted.items() if own or name not in table}  # its last table is gone
    for candidate in _candidates(text, table, key, value):
        with suppress(tomllib.TOMLDecodeError):
            if tomllib.loads(candidate) in (wanted, bare if value is REMOVED else wanted):
                return candidate
    line = line_of(text, *table, key)
    where = f"line {line}" if line else f"the table {'.'.join(table)}"
    raise UsageError(f"{key} of [{'.'.join(table)}] cannot be changed without harm to the text; edit {where} by hand")


def _candidates(text: str, table: tuple[str, ...], key: str, value: object) -> Iterator[str]:
    """Yield texts that may have the change; only one that reads as wanted counts."""
    lines = re.findall(r"[^\n]*\n|[^\n]+", text)
    new = "" if value is REMOVED else f"{toml_value({key: value})[2:-2]}\n"
    name = ".".join(toml_value({part: 0})[2:-2].partition(" =")[0] for part in table)
    at = line_of(text, *table, key) - 1
    for line in (new, new and f"{name}.{new}") if key and at >= 0 else ():
        yield "".join((*lines[:at], *([_with_comment(lines[at], line)] if line else []), *lines[at + 1 :]))
    if value is REMOVED and at >= 0:
        yield _without_table(lines, at)
    if head := line_of(text, *table):
        yield "".join((*lines[:head], new, *lines[head:]))
        yield "".join((*lines[: head - 1], new and f"{name}.{new}", *lines[head - 1 :]))  # beside a dotted key
    gap = "" if not text else "\n" if text.endswith("\n") else "\n\n"
    yield f"{text}{gap}[{name}]\n{new}"


def _without_table(lines: Sequence[str], at: int) -> str:
    """Return *lines* without the table that begins *at* a line; the comments above the next table stay."""
    end = next((line for line in range(at + 1, len(lines)) if lines[line].startswith("[")), len(lines))
    while lines[end - 1].startswith("#") or not lines[end - 1].strip():
        end -= 1
    return "".join((*lines[: at - (at > 0 and not lines[at - 1].strip())], *lines[end:]))


def _with_comment(old: str, new: str) -> str:
    """Return the line *new* with indent and comment of *old*."""
    indent = old[: len(old) - len(old.lstrip())]
    code = cast("re.Match[str]", _CODE.match(old)).group()
    with suppress(tomllib.TOMLDecodeError):
        if old.startswith("#", len(code)):
            tomllib.loads(code)
            return f"{indent}{new.rstrip()}{old[len(code.rstrip()) :]}"
    return indent + new
