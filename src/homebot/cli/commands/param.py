"""``homebot param``: ``list``, ``get``, ``set``, ``describe``, ``dump`` and ``load``."""

import argparse
import json
import sys
from collections.abc import Iterator
from typing import Any, Final, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.yaml import parse_flow, read_yaml, to_yaml
from homebot.errors import PeerError, UsageError, WireError
from homebot.names import absolute_name
from homebot.plugins import check_extra
from homebot.support.printable import printable
from homebot.support.similar import did_you_mean

_TYPES: Final = ("", "bool", "integer", "double", "string", "byte[]", "bool[]", "integer[]", "double[]", "string[]")

_EXAMPLES = """\
  homebot param list
  homebot param get /gateway/mqtt stale_after
  homebot param dump /gateway/mqtt
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    helps = {
        "name": "name of the parameter",
        "value": "new value, as YAML: 5, 0.5, true, hall, [1, 2]",
        "file": "YAML in the form of `dump`; - reads standard input",
    }
    for verb, summary, run, example, arguments in (
        ("list", "list the parameters of all nodes, or of one", _list, "/gateway/mqtt", ()),
        ("get", "print the value of a parameter", _get, "/gateway/mqtt stale_after", ("name",)),
        ("set", "set a parameter", _set, "/robot speed 0.5", ("name", "value")),
        ("describe", "explain a parameter", _describe, "/gateway/mqtt stale_after", ("name",)),
        ("dump", "print the parameters of a node as a file for `load`", _dump, "/gateway/mqtt", ()),
        ("load", "set the parameters of a node from a file", _load, "/robot robot.yaml", ("file",)),
    ):
        command = add_verb(verbs, verb, summary)
        command.add_argument(
            "node", metavar="NODE", nargs="?" if verb == "list" else None, help="full name of the node"
        )
        for argument in arguments:
            command.add_argument(argument, metavar=argument.upper(), help=helps[argument])
        set_door_command(command, run, f"  homebot param {verb} {example}\n", acts=verb in {"set", "load"})


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    nodes = _names(door)
    for node in [_node(options.node, nodes)] if options.node else nodes:
        print(f"{node}:", *nodes[node], sep="\n  ")
    return 0


def _get(door: DoorClient, options: argparse.Namespace) -> int:
    print(to_yaml(_value(door, options.node, options.name)), end="")
    return 0


def _set(door: DoorClient, options: argparse.Namespace) -> int:
    try:
        value = parse_flow(options.value)
    except WireError as exc:
        raise UsageError(str(exc)) from exc
    return _set_value(door, options.node, options.name, value)


def _describe(door: DoorClient, options: argparse.Namespace) -> int:
    _value(door, options.node, options.name)
    node = _node(options.node, _names(door))
    answer = cast("dict[str, Any]", door.call(f"{node}/describe_parameters", {"names": [options.name]}))
    (found,) = answer["descriptors"]
    limits: dict[str, Any] = next(iter((*found["integer_range"], *found["floating_point_range"])), {})
    rows = {
        "type": _TYPES[found["type"]],
        "description": found["description"],
        "minimum": limits.get("from_value"),
        "maximum": limits.get("to_value"),
        "read_only": found["read_only"],
    }
    print(to_yaml({name: value for name, value in rows.items() if value not in ("", None)}), end="")
    return 0


def _dump(door: DoorClient, options: argparse.Namespace) -> int:
    """Print the parameters of a node as YAML, nested by the dots in their names, like the ROS tool."""
    nodes = _names(door)
    node = _node(options.node, nodes)
    found: dict[str, object] = {}
    for name in sorted(nodes[node]):
        _insert(found, name, _value(door, node, name))
    print(to_yaml({node: {"ros__parameters": found}}), end="")
    return 0


def _insert(table: dict[str, Any], name: str, value: object) -> None:
    first, dot, rest = name.partition(".")
    inner = table.setdefault(first, {}) if dot else None
    if isinstance(inner, dict):
        _insert(inner, rest, value)
    else:  # even below a parameter that has its own value
        table[name] = value


def _load(door: DoorClient, options: argparse.Namespace) -> int:
    node = _node(options.node, _names(door))
    return max([_set_value(door, node, name, value) for name, value in _read_params(options.file, node).items()])


def _read_params(file: str, node: str) -> dict[str, object]:
    """Return the parameters in *file* for the full name *node*: those for all nodes (``/**``), then its own."""
    check_extra("`homebot param load`", "maps", "yaml")
    found: dict[str, dict[str, object]] = {}
    for keys, value in _leaves(read_yaml(file)):
        node_name, marker, name = ".".join(keys).partition(".ros__parameters.")
        if marker:
            found.setdefault(f"/{node_name.lstrip('/').replace('.', '/')}", {})[name] = value
    if not (wanted := found.get("/**", {}) | found.get(node, {})):
        raise UsageError(f"{file} has no ros__parameters for {node}, only for {', '.join(found) or 'no node'}")
    return wanted


def _leaves(value: object, keys: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    if not isinstance(value, dict):
        yield keys, value
        return
    for key, item in value.items():
        yield from _leaves(item, (*keys, str(key)))


def _names(door: DoorClient) -> dict[str, list[str]]:
    nodes: dict[str, list[str]] = {}
    for one in cast("list[str]", door.call("/rosapi/get_param_names")["names"]):
        node, _, name = one.partition(":")
        nodes.setdefault(node, []).append(name)
    return nodes


def _node(name: str, nodes: dict[str, list[str]]) -> str:
    full_name = absolute_name(name)
    if full_name not in nodes:
        hint = did_you_mean(full_name, nodes, "`homebot param list` lists nodes that have some")
        raise PeerError(f"{full_name} has no parameters; {hint}")
    return full_name


def _value(door: DoorClient, node: str, name: str) -> Any:
    answer = door.call("/rosapi/get_param", {"name": f"{node}:{name}", "default_value": ""})
    if not answer["successful"]:
        raise PeerError(printable(str(answer["reason"])))
    return json.loads(str(answer["value"]))


def _set_value(door: DoorClient, node: str, name: str, value: object) -> int:
    full_name = f"/{node.lstrip('/')}:{name}"
    answer = door.call("/rosapi/set_param", {"name": full_name, "value": json.dumps(value, default=str)})
    if answer["successful"]:
        print(f"{name} is {json.dumps(value, default=str)}")
        return 0
    print(f"homebot: {printable(str(answer['reason'])).removeprefix(f'{full_name}: ')}", file=sys.stderr)
    return 1
