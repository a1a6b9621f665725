"""``homebot param``: ``list`` and ``get``."""

import argparse
import json
from typing import Final

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.errors import PeerError
from homebot.names import absolute_name
from homebot.support.printable import printable

_WORDS: Final = {bool: "Boolean", int: "Integer", float: "Double", str: "String"}
_EXAMPLES: Final = """\
  homebot param list
  homebot param get /light_service delay
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the parameters of every node")
    set_door_command(command, _list, "  homebot param list\n")
    command = add_verb(verbs, "get", "print the value of a parameter")
    command.add_argument("node", metavar="NODE", help="name of the node")
    command.add_argument("parameter", metavar="NAME", help="name of the parameter")
    command.add_argument("--hide-type", action="store_true", help="print only the value")
    set_door_command(command, _get, "  homebot param get /light_service delay\n")


def _list(door: DoorClient, _options: argparse.Namespace) -> int:
    names = door.call("/rosapi/get_param_names")["names"]
    assert isinstance(names, list)  # noqa: S101 - for the type checker
    before = ""
    for full_name in sorted(names):
        node, _, name = full_name.rpartition(":")
        if node != before:
            print(f"{node}:")
        print(f"  {name}")
        before = node
    return 0


def _get(door: DoorClient, options: argparse.Namespace) -> int:
    answer = door.call("/rosapi/get_param", {"name": f"{absolute_name(options.node)}:{options.parameter}"})
    if not answer["successful"]:
        raise PeerError(printable(str(answer["reason"]), 500))
    value = json.loads(str(answer["value"]))
    text = printable(str(value), 10_000)
    one = value[0] if isinstance(value, list) and value else value
    if options.hide_type:
        print(text)
    else:
        print(f"{_WORDS.get(type(one), 'The')} {'values are' if isinstance(value, list) else 'value is'}: {text}")
    return 0
