"""The ``--ros-args`` of programs: other names of nodes, topics, services and actions, and values of parameters.

Source: ROS 2, "Node arguments": ``-r FROM:=TO`` and ``-p NAME:=VALUE``, perhaps after ``NODE:``. Others are ignored.
"""

import ast
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Final

_KINDS: Final = {"-r": "-r", "--remap": "-r", "-p": "-p", "--param": "-p"}
_READERS: Final[tuple[Callable[[str], object], ...]] = (json.loads, ast.literal_eval)


def node_rules(words: Sequence[str], node: str) -> tuple[dict[str, str], dict[str, object]]:
    """Return the new names by old ones, ``__node`` and ``__ns`` included, and the parameters of *node*."""
    names: dict[str, str] = {}
    parameters: dict[str, object] = {}
    before = ""
    for word in _split(words)[1]:
        if (kind := _KINDS.get(before)) is not None:
            left, _, value = word.partition(":=")
            concerned, _, name = left.rpartition(":")
            if concerned not in {"", node}:
                pass
            elif kind == "-r":
                names["__node" if name == "__name" else name] = value
            else:
                parameters[name] = _value(value)
        before = word
    return names, parameters


def remove_ros_args(args: Sequence[str]) -> list[str]:
    """Return the arguments of the program itself."""
    return _split(args)[0]


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments of the program, and those of ROS."""
    parts: tuple[list[str], list[str]] = ([], [])
    is_of_ros = False
    for word in words:
        if word == "--ros-args" or (is_of_ros and word == "--"):
            is_of_ros = word != "--"
        else:
            parts[is_of_ros].append(word)
    return parts


def _value(text: str) -> object:
    """Return a value written in YAML, of the kinds that parameters have."""
    for read in _READERS:
        with suppress(ValueError, SyntaxError):
            return read(text)
    return text
