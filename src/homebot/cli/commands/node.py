"""``homebot node list`` and ``homebot node info``."""

import argparse
from collections import Counter

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities, is_hidden, not_found
from homebot.names import absolute_name

_SECTIONS = {
    "subscription": "Subscribers",
    "publisher": "Publishers",
    "service": "Service Servers",
    "client": "Service Clients",
    "action server": "Action Servers",
    "action client": "Action Clients",
}


_EXAMPLES = """\
  homebot node list
  homebot node info /rosapi
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list every node")
    command.add_argument("-a", "--all", action="store_true", help="show hidden nodes too")
    set_door_command(command, _list, "  homebot node list\n")
    command = add_verb(verbs, "info", "show what a node publishes, subscribes to and serves")
    command.add_argument("node", metavar="NODE", help="full name of the node")
    set_door_command(command, _info, "  homebot node info /rosapi\n")


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    others = Counter(entity.name for entity in entities(door, kind="node", elsewhere=True))
    for entity in entities(door, kind="node"):
        others[entity.name] -= 1  # a node here may have the same name
        if options.all or not is_hidden(entity):
            print(f"{entity.name}  (elsewhere)" if others[entity.name] >= 0 else entity.name)
    return 0


def _info(door: DoorClient, options: argparse.Namespace) -> int:
    name = absolute_name(options.node)
    ends = [*entities(door, node=name), *entities(door, node=name, elsewhere=True)]
    if not ends:
        known = [entity.name for entity in entities(door, kind="node")]
        raise not_found("node", name, known)
    print(name)
    for kind, title in _SECTIONS.items():
        print(f"  {title}:")
        for line in sorted({f"    {end.name}: {end.type}" for end in ends if end.kind == kind and not is_hidden(end)}):
            print(line)
    return 0
