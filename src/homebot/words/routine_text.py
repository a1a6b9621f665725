"""The text of a routine: a table ``[[routines]]`` in TOML. Pure."""

import re
from collections.abc import Mapping
from typing import Final

from homebot.support.toml_text import toml_value

_WIDTH: Final = 100


def routine_text(table: Mapping[str, object]) -> str:
    """Return *table* as TOML, as a person would write it."""
    return "".join(("[[routines]]\n", *(f"{key} = {_lines(value)}\n" for key, value in table.items())))


def rename_scene(text: str, old: str, new: str) -> str:
    """Return the table *text* of a routine, with the scene *old* called *new* in the steps that apply it."""
    name = rf"""(?P<inner>\\?["'])?{re.escape(old)}(?(inner)(?P=inner))"""
    step = re.compile(rf"""(?P<quote>["'])scene\s+{name}(?=\s*(?:,|(?P=quote)))""", re.IGNORECASE)
    return step.sub(lambda match: f"{match['quote']}scene {new}", text)


def _lines(value: object) -> str:
    """Return *value* on one line if it is short, else each of its elements on its own."""
    line = toml_value(value)
    if not isinstance(value, list | tuple) or len(line) <= _WIDTH:
        return line
    return f"[\n{''.join(f'    {toml_value(one)},{chr(10)}' for one in value)}]"
