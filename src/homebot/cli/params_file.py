"""Parameters of nodes in the file format of ROS: ``{NODE: {ros__parameters: {NAME: VALUE}}}`` as YAML.

Read are blocks of keys by indentation, lists with dashes, comments, and values as :mod:`homebot.cli.flow` reads them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from homebot.cli.flow import FlowValue, parse_flow
from homebot.errors import WireError

__all__ = ["read_params"]

_PARAMETERS: Final = "ros__parameters"
_COMMENT: Final = re.compile(r"""("[^"]*"|'[^']*')|(?:^|\s+)(?:#.*|---)?$""")
_LINE: Final = re.compile(r"""( *)(?:(-) |["']?([^"':]+)["']?:(?: +|$))(.*)""")


def read_params(text: str, node: str) -> dict[str, FlowValue]:
    """Return the parameters for *node*, a full name, in *text*: those for all nodes (``/**``), then its own.

    Nested ones have names with dots.

    Raises:
        WireError: It is no such file, or has none for the node; the message names the line, or the nodes that it has.
    """
    found: dict[str, dict[str, FlowValue]] = {}
    for keys, value in _leaves(text):
        if len(keys) < 3 or keys[1] != _PARAMETERS:
            raise WireError(f"parameters are below NODE and {_PARAMETERS}, got {': '.join(keys)}")
        found.setdefault(f"/{keys[0].lstrip('/')}", {})[".".join(keys[2:])] = value
    wanted = found.get("/**", {}) | found.get(node, {})
    if not wanted:
        raise WireError(f"it has no parameters for {node}, but for {', '.join(found) or 'no node'}")
    return wanted


def _leaves(text: str) -> Iterator[tuple[tuple[str, ...], FlowValue]]:
    """Yield each value with the keys that lead to it; a list with dashes after each of its items."""
    opened: list[tuple[int, str, list[FlowValue]]] = []
    for number, line in enumerate(text.splitlines(), 1):
        content = _COMMENT.sub(r"\1", line)
        if not content:
            continue
        parts = _LINE.fullmatch(content)
        if parts is None:
            raise WireError(f"line {number}: a name and a colon were expected, got {content.strip()[:60]!r}")
        indent, dash, key, given = len(parts[1]), parts[2], parts[3], parts[4]
        while opened and (opened[-1][0] > indent or (opened[-1][0] == indent and not dash)):
            opened.pop()
        if not dash:
            opened.append((indent, key, []))
        if not given or not opened:
            continue
        try:
            value = parse_flow(given)
        except WireError as exc:
            raise WireError(f"line {number}: {exc}") from exc
        keys = tuple(key for _, key, _ in opened)
        if dash:
            opened[-1][2].append(value)
            yield keys, opened[-1][2]
        else:
            yield from _flat(keys, value)


def _flat(keys: tuple[str, ...], value: FlowValue) -> Iterator[tuple[tuple[str, ...], FlowValue]]:
    if not isinstance(value, dict):
        yield keys, value
        return
    for key, item in value.items():
        yield from _flat((*keys, key), item)
