"""``homebot param``: ``list``, ``get``, ``set``, ``describe``, ``dump`` and ``load``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, cast

from homebot.cli.arguments import Commands, add_verb, add_verbs, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.flow import FlowValue, parse_flow
from homebot.cli.params_file import params_for, read_params_file
from homebot.cli.table import printable
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError, UsageError, WireError
from homebot.support.similar import did_you_mean

__all__ = ["add_arguments"]

_TYPES: Final = {
    1: ("Boolean", "bool_value"),
    2: ("Integer", "integer_value"),
    3: ("Double", "double_value"),
    4: ("String", "string_value"),
    5: ("Byte", "byte_array_value"),
    6: ("Boolean", "bool_array_value"),
    7: ("Integer", "integer_array_value"),
    8: ("Double", "double_array_value"),
    9: ("String", "string_array_value"),
}
"""The types of ``rcl_interfaces/msg/ParameterType`` in words, and the fields of ``ParameterValue``."""

_NAMES: Final = {1: "boolean", 2: "integer", 3: "double", 4: "string", 5: "byte array"}
_NAMES_OF_ARRAYS: Final = {6: "boolean array", 7: "integer array", 8: "double array", 9: "string array"}
_FIRST_ARRAY: Final = 5
_NUMBERS: Final = {bool: 1, int: 2, float: 3, str: 4}

_EXAMPLES = """\
  homebot param list
  homebot param get /gateway/mqtt stale_after
  homebot param dump /gateway/mqtt
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the commands below ``homebot param``."""
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the parameters of all nodes, or of one")
    command.add_argument("node", metavar="NODE", nargs="?", help="full name of the node")
    set_client_command(command, _list, "  homebot param list\n  homebot param list /gateway/mqtt\n")
    _add(verbs, "get", "print the value of a parameter", _get, "/gateway/mqtt stale_after", "name")
    _add(verbs, "set", "set a parameter", _set, "/robot speed 0.5", "name", "value")
    _add(verbs, "describe", "explain a parameter", _describe, "/gateway/mqtt stale_after", "name")
    _add(verbs, "dump", "print the parameters of a node as a file for `load`", _dump, "/gateway/mqtt")
    _add(verbs, "load", "set the parameters of a node from a file", _load, "/robot robot.yaml", "file")


def _add(
    verbs: Commands, name: str, summary: str, run: Callable[[argparse.Namespace], int], example: str, *arguments: str
) -> None:
    helps = {
        "name": "name of the parameter",
        "value": "new value, as YAML: 5, 0.5, true, hall, [1, 2]",
        "file": "YAML as `dump` prints it; - reads standard input",
    }
    command = add_verb(verbs, name, summary)
    command.add_argument("node", metavar="NODE", help="full name of the node")
    for argument in arguments:
        command.add_argument(argument, metavar=argument.upper(), help=helps[argument])
    set_client_command(command, run, f"  homebot param {name} {example}\n")


def _list(options: argparse.Namespace) -> int:
    """Print the names of parameters below the name of their node."""

    def run(door: DoorClient) -> int:
        nodes = _names(door)
        wanted = [_node(options.node, nodes)] if options.node else list(nodes)
        for node in wanted:
            print(f"{node}:")
            for name in nodes[node]:
                print(f"  {name}")
        return 0

    return with_client(options, run)


def _get(options: argparse.Namespace) -> int:
    """Print the type and the value of a parameter."""

    def run(door: DoorClient) -> int:
        node, name = _parameter(door, options)
        (value,) = _values(door, node, [name])
        number = value["type"]
        words, field = _TYPES[number]
        verb = "values are" if number >= _FIRST_ARRAY else "value is"
        shown = value[field]
        print(f"{words} {verb}: {printable(shown) if isinstance(shown, str) else shown}")
        return 0

    return with_client(options, run)


def _set(options: argparse.Namespace) -> int:
    """Set a parameter; return 1 where its node refuses the value."""
    value = _read_value(options.value)

    def run(door: DoorClient) -> int:
        node, name = _parameter(door, options)
        (result,) = _set_values(door, node, {name: value})
        if not result["successful"]:
            raise PeerError(f"{node} refused it: {printable(str(result['reason']))}")
        print("Set parameter successful")
        return 0

    return with_client(options, run)


def _describe(options: argparse.Namespace) -> int:
    """Print the type, the description and the limits of a parameter."""

    def run(door: DoorClient) -> int:
        node, name = _parameter(door, options)
        (found,) = _call(door, node, "describe_parameters", names=[name])["descriptors"]
        print(f"Parameter name: {found['name']}")
        print(f"  Type: {_type_name(found['type'])}")
        if found["description"]:
            print(f"  Description: {printable(found['description'])}")
        print("  Constraints:")
        for span in (*found["integer_range"], *found["floating_point_range"]):
            print(f"    Min value: {span['from_value']}\n    Max value: {span['to_value']}")
        if found["additional_constraints"]:
            print(f"    Additional constraints: {printable(found['additional_constraints'])}")
        print(f"    Read only: {str(found['read_only']).lower()}")
        return 0

    return with_client(options, run)


def _dump(options: argparse.Namespace) -> int:
    """Print the parameters of a node as YAML."""

    def run(door: DoorClient) -> int:
        nodes = _names(door)
        node = _node(options.node, nodes)
        values = zip(nodes[node], _values(door, node, nodes[node]), strict=True)
        parameters: dict[str, object] = {name: value[_TYPES[value["type"]][1]] for name, value in values}
        print(to_yaml({node: {"ros__parameters": parameters}}), end="")
        return 0

    return with_client(options, run)


def _load(options: argparse.Namespace) -> int:
    """Set the parameters of a node that a file names; return 1 where the node refuses one."""
    path = Path(options.file)
    try:
        text = sys.stdin.read() if options.file == "-" else path.read_text()
        nodes = read_params_file(text)
    except (OSError, UnicodeDecodeError, WireError) as exc:
        raise UsageError(f"cannot read {options.file}: {exc}") from exc

    def run(door: DoorClient) -> int:
        node = _node(options.node, _names(door))
        wanted = params_for(node, nodes)
        if not wanted:
            raise UsageError(f"{options.file} has no parameters for {node}; it has {', '.join(nodes) or 'none'}")
        results = _set_values(door, node, wanted)
        for name, result in zip(wanted, results, strict=True):
            outcome = "successful" if result["successful"] else f"failed: {printable(str(result['reason']))}"
            print(f"Set parameter {name} {outcome}")
        return 0 if all(result["successful"] for result in results) else 1

    return with_client(options, run)


def _names(door: DoorClient) -> dict[str, list[str]]:
    """Return the names of all parameters by the full names of their nodes."""
    nodes: dict[str, list[str]] = {}
    for one in cast("list[str]", door.call("/rosapi/get_param_names")["names"]):
        node, _, name = one.partition(":")
        nodes.setdefault(node, []).append(name)
    return nodes


def _parameter(door: DoorClient, options: argparse.Namespace) -> tuple[str, str]:
    """Return the full name of the node and the name of the parameter that *options* name.

    Raises:
        PeerError: There is no such node or no such parameter.
    """
    nodes = _names(door)
    node = _node(options.node, nodes)
    if options.name not in nodes[node]:
        hint = did_you_mean(options.name, nodes[node], f"`homebot param list {node}` lists all")
        raise PeerError(f"{node} has no parameter {options.name}; {hint}")
    return node, options.name


def _node(name: str, nodes: Mapping[str, list[str]]) -> str:
    full_name = name if name.startswith("/") else f"/{name}"
    if full_name not in nodes:
        raise PeerError(f"{full_name} has no parameters; `homebot param list` lists all that have")
    return full_name


def _values(door: DoorClient, node: str, names: list[str]) -> list[dict[str, Any]]:
    values: list[dict[str, Any]] = _call(door, node, "get_parameters", names=names)["values"]
    return values


def _set_values(door: DoorClient, node: str, values: Mapping[str, FlowValue]) -> list[dict[str, object]]:
    parameters = [{"name": name, "value": _to_message(name, value)} for name, value in values.items()]
    results: list[dict[str, object]] = _call(door, node, "set_parameters", parameters=parameters)["results"]
    return results


def _call(door: DoorClient, node: str, service: str, **request: object) -> dict[str, Any]:
    return cast("dict[str, Any]", door.call(f"{node}/{service}", request))


def _to_message(name: str, value: FlowValue) -> dict[str, object]:
    """Return *value* as a ``rcl_interfaces/msg/ParameterValue``."""
    items = value if isinstance(value, list) else [value]
    kinds = {type(item) for item in items}
    kind = float if kinds == {int, float} else kinds.pop() if len(kinds) == 1 else None
    number = _NUMBERS.get(kind, 0) if kind else 0
    if isinstance(value, list):
        number = number + _FIRST_ARRAY if number else 0 if value else 9
    if not number:
        raise UsageError(f"{name}: a parameter is a bool, number, text, or a list of one of these, got {value!r}")
    return {"type": number, _TYPES[number][1]: value}


def _read_value(text: str) -> FlowValue:
    try:
        return parse_flow(text)
    except WireError as exc:
        raise UsageError(str(exc)) from exc


def _type_name(number: int) -> str:
    return {**_NAMES, **_NAMES_OF_ARRAYS}.get(number, f"type {number}")
