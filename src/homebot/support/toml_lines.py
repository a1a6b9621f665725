"""The lines of the keys of a file of TOML, which its reader does not tell. Pure."""

import re
from collections import Counter
from functools import lru_cache
from typing import Final

_NAME: Final = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_PATH: Final = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEAD: Final = re.compile(rf"\s*(?P<bracket>\[\[?)\s*(?P<path>{_PATH})\s*\]")
_KEY: Final = re.compile(rf"\s*(?P<path>{_PATH})\s*=")
_PIECE: Final = re.compile(
    r"""
    \"{3}(?:[^\\]|\\.)*?"{3} | '{3}.*?'{3} | "(?:[^"\\\n]|\\.)*" | '[^'\n]*'  # texts
    | \#[^\n]* | [\[\]{},\n] | [^\s\[\]{},\#"']+ | ["']
    """,
    re.VERBOSE | re.DOTALL,
)


def line_of(text: str, *path: str) -> int:
    """Return the line of the key *path* in *text*, or of the innermost table or array around it; 0 if there is none.

    Args:
        path: Names of keys, and numbers of tables and elements from 0 on.
    """
    keys = _lines_of_keys(text)
    known = next((path[:length] for length in range(len(path), 0, -1) if path[:length] in keys), None)
    if known is None:
        return 0
    line = keys[known]
    element = path[len(known) :][:1]
    elements = _lines_of_elements(text, line) if element and element[0].isdigit() else ()
    return elements[int(element[0])] if element and elements and int(element[0]) < len(elements) else line


@lru_cache(maxsize=1)  # the mistakes in a file follow each other
def _lines_of_keys(text: str) -> dict[tuple[str, ...], int]:
    here, tables, lines = tuple[str, ...](), Counter[tuple[str, ...]](), dict[tuple[str, ...], int]()
    for number, line in enumerate(text.split("\n"), 1):
        if (head := _HEAD.match(line)) is not None:
            here = _names(head["path"])
            if head["bracket"] == "[[":
                tables[here] += 1
                here = (*here, str(tables[here] - 1))
            lines.setdefault(here, number)
        elif (key := _KEY.match(line)) is not None:
            names = _names(key["path"])
            for length in range(1, len(names) + 1):
                lines.setdefault((*here, *names[:length]), number)
    return lines


def _names(path: str) -> tuple[str, ...]:
    return tuple(name.strip("\"'") for name in re.findall(_NAME, path))


@lru_cache(maxsize=1)
def _lines_of_elements(text: str, line: int) -> tuple[int, ...]:
    """Return the lines in which the elements of the array begin whose key is in *line*; none of another value."""
    *_, rest = text.split("\n", line - 1)
    key, depth, is_open, lines = _KEY.match(rest), 0, False, list[int]()
    for piece in () if key is None else (match[0] for match in _PIECE.finditer(rest, key.end())):
        if depth == 1 and is_open and piece[0] not in "\n#],":
            lines.append(line)
            is_open = False
        if piece in "[{":
            depth += 1
            is_open = depth == 1
        elif piece in "]}":
            depth -= 1
        elif piece == ",":
            is_open = is_open or depth == 1
        line += piece.count("\n")
        if not depth:
            break
    return tuple(lines)
