"""``homebot param``: ``list``, ``get`` and ``set``."""

import argparse
import json
import sys
from typing import Any, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.yaml import parse_flow, to_yaml
from homebot.errors import PeerError, UsageError, WireError
from homebot.names import absolute_name
from homebot.support.printable import printable
from homebot.support.similar import did_you_mean

_EXAMPLES = """\
  homebot param list
  homebot param get /gateway/mqtt stale_after
  homebot param set /robot speed 0.5
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    helps = {
        "name": "name of the parameter",
        "value": "new value, as YAML: 5, 0.5, true, hall, [1, 2]",
    }
    for verb, summary, run, example, arguments in (
        ("list", "list the parameters of all nodes, or of one", _list, "/gateway/mqtt", ()),
        ("get", "print the value of a parameter", _get, "/gateway/mqtt stale_after", ("name",)),
        ("set", "set a parameter", _set, "/robot speed 0.5", ("name", "value")),
    ):
        command = add_verb(verbs, verb, summary)
        command.add_argument(
            "node", metavar="NODE", nargs="?" if verb == "list" else None, help="full name of the node"
        )
        for argument in arguments:
            command.add_argument(argument, metavar=argument.upper(), help=helps[argument])
        set_door_command(command, run, f"  homebot param {verb} {example}\n", acts=verb == "set")


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
