"""``homebot node list``."""

import argparse
from collections import Counter

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities, is_hidden

_EXAMPLES = """\
  homebot node list
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list every node")
    command.add_argument("-a", "--all", action="store_true", help="show hidden nodes too")
    set_door_command(command, _list, "  homebot node list\n")


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    others = Counter(entity.name for entity in entities(door, kind="node", elsewhere=True))
    for entity in entities(door, kind="node"):
        others[entity.name] -= 1  # a node here may have the same name
        if options.all or not is_hidden(entity):
            print(f"{entity.name}  (elsewhere)" if others[entity.name] >= 0 else entity.name)
    return 0
