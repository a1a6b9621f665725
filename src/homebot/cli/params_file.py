"""Parameters of nodes in the file format of ROS: ``{NODE: {ros__parameters: {NAME: VALUE}}}`` as YAML.

Read are blocks of keys by indentation, lists with dashes, and values as :mod:`homebot.cli.flow` reads them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from homebot.cli.flow import FlowValue, parse_flow
from homebot.errors import WireError

__all__ = ["params_for", "read_params_file"]

_PARAMETERS = "ros__parameters"


class _Line(NamedTuple):
    number: int
    indent: int
    text: str


def read_params_file(text: str) -> dict[str, dict[str, FlowValue]]:
    """Return the parameters in *text* by the name of their node; nested ones have names with dots.

    Raises:
        WireError: It is no such file; the message names the line.
    """
    lines = [
        _Line(number, len(line) - len(line.lstrip()), line.strip())
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(("#", "---"))
    ]
    nodes: dict[str, dict[str, FlowValue]] = {}
    for node, given in _mapping(lines).items():
        parameters = given.get(_PARAMETERS) if isinstance(given, dict) else None
        if not isinstance(parameters, dict):
            raise WireError(f"the file has no {_PARAMETERS} below {node!r}")
        nodes[node] = dict(_flat(parameters))
    return nodes


def params_for(node: str, nodes: Mapping[str, Mapping[str, FlowValue]]) -> dict[str, FlowValue]:
    """Return the parameters for *node*, a full name: those for all nodes (``/**``), then its own."""
    found: dict[str, FlowValue] = {}
    for name, parameters in nodes.items():
        if name == "/**" or f"/{name.lstrip('/')}" == node:
            found.update(parameters)
    return found


def _flat(values: Mapping[str, FlowValue], prefix: str = "") -> Iterator[tuple[str, FlowValue]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _mapping(lines: list[_Line]) -> dict[str, FlowValue]:
    """Return the keys of a block, whose lines begin with the indentation of the first."""
    found: dict[str, FlowValue] = {}
    for line, below in _blocks(lines):
        key, colon, rest = (
            line.text.partition(": ") if ": " in line.text else (line.text.removesuffix(":"), line.text[-1:], "")
        )
        if not colon.startswith(":"):
            raise WireError(f"line {line.number}: a name and a colon were expected, got {line.text[:60]!r}")
        found[key.strip("\"'")] = _value(line, rest, below)
    return found


def _value(line: _Line, rest: str, below: list[_Line]) -> FlowValue:
    if rest:
        try:
            return parse_flow(rest)
        except WireError as exc:
            raise WireError(f"line {line.number}: {exc}") from exc
    if below and below[0].text.startswith("- "):
        return [_value(one, one.text.removeprefix("- "), []) for one, _ in _blocks(below)]
    return _mapping(below)


def _blocks(lines: list[_Line]) -> Iterator[tuple[_Line, list[_Line]]]:
    """Yield each line of the first one's indentation, with the lines below it; a list may be indented as its key is."""
    starts = [
        at
        for at, line in enumerate(lines)
        if line.indent <= lines[0].indent and line.text.startswith("- ") == lines[0].text.startswith("- ")
    ]
    for at, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        yield lines[at], lines[at + 1 : end]
