"""The text of a routine: a table ``[[routines]]`` in TOML. Pure."""

import re
from collections.abc import Mapping
from typing import Final

from homebot.support.toml_text import toml_value
from homebot.words.own_language import to_english
from homebot.words.phrases import SCENE
from homebot.words.tokens import MAX_QUERY

_WIDTH: Final = 100
_STRING: Final = re.compile(r""""(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'""")


def routine_text(table: Mapping[str, object]) -> str:
    """Return *table* as TOML, as a person would write it."""
    return "".join(("[[routines]]\n", *(f"{key} = {_lines(value)}\n" for key, value in table.items())))


def rename_scene(text: str, old: str, new: str) -> str:
    """Return the table *text* of a routine, with the scene *old* called *new* in the steps of any language with it."""
    name = re.compile(rf"""(?P<inner>\\?["'])?{re.escape(old)}(?(inner)(?P=inner))""", re.IGNORECASE)

    def renamed(string: re.Match[str]) -> str:
        step = string[0][1:-1].replace('\\"', '"')
        applied = SCENE.match(to_english(step, "step") or step) if len(step) < MAX_QUERY else None
        if applied is None or applied["name"].strip("\"'").casefold() != old.casefold():
            return string[0]
        for place in [*name.finditer(string[0])][-1:]:
            return f"{string[0][: place.start()]}{new}{string[0][place.end() :]}"
        return string[0]

    return _STRING.sub(renamed, text)


def _lines(value: object) -> str:
    """Return *value* on one line if it is short, else each of its elements on its own."""
    line = toml_value(value)
    if not isinstance(value, list | tuple) or len(line) <= _WIDTH:
        return line
    return f"[\n{''.join(f'    {toml_value(one)},{chr(10)}' for one in value)}]"
