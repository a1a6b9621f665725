"""The lines of the keys of a file of TOML, which its reader does not tell. Pure."""

import re
import tomllib
from collections import Counter
from contextlib import suppress
from typing import Final

_NAME: Final = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_PATH: Final = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEAD: Final = re.compile(rf"\s*(?P<bracket>\[\[?)\s*(?P<path>{_PATH})\s*\]")
_MAX_LINES: Final = 200
"""Lines of an array in which an element is searched for."""

_KEY: Final = re.compile(rf"\s*(?P<path>{_PATH})\s*=")


def line_of(text: str, *path: str) -> int:
    """Return the line of the key *path* in *text*, or of the innermost table or array around it; 0 if there is none.

    Args:
        path: Names of keys, and numbers of tables and elements from 0 on.
    """
    lines, here, tables = text.splitlines(), tuple[str, ...](), Counter[tuple[str, ...]]()
    found: dict[tuple[str, ...], int] = {}
    for number, line in enumerate(lines, 1):
        if (head := _HEAD.match(line)) is not None:
            here = _names(head["path"])
            if head["bracket"] == "[[":
                tables[here] += 1
                here = (*here, str(tables[here] - 1))
            found.setdefault(here, number)
        elif (key := _KEY.match(line)) is not None:
            names = _names(key["path"])
            for length in range(1, len(names) + 1):
                found.setdefault((*here, *names[:length]), number)
    known = next((path[:length] for length in range(len(path), 0, -1) if path[:length] in found), None)
    if known is None:
        return 0
    element = path[len(known) :][:1]
    return _line_of_element(lines, found[known], int(element[0])) if element and element[0].isdigit() else found[known]


def _names(path: str) -> tuple[str, ...]:
    return tuple(one.strip("\"'") for one in re.findall(_NAME, path))


def _line_of_element(lines: list[str], first: int, number: int) -> int:
    """Return the line of an element of the array that begins in line *first*: the array is whole if it ended there."""
    for last in range(first, min(first + _MAX_LINES, len(lines)) + 1):
        array = "\n".join(lines[first - 1 : last])
        for end in ("\n]", ""):
            with suppress(ValueError, RecursionError):
                (value,) = tomllib.loads(array + end).values()
                if isinstance(value, list) and len(value) > number:
                    return last
    return first
