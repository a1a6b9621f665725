"""``homebot group``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.device_json import json_text, list_text
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_line, print_table
from homebot.devices.names import LIST_GROUPS
from homebot.devices.wording.json_message import fields_of
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.group_messages import GroupInfo, ListGroupsResponse

_EXAMPLES: Final = """\
  homebot group list                    the groups of the configuration, and those of gateways
  homebot group show 'Evening lamps'    its members, and the message that reaches all of them
  homebot do 'Evening lamps' off        command each member; queries find them by group="Evening lamps"

A group of your own is a table in homebot.toml, which `homebot reload` reads again:

  [[groups]]
  name = "Evening lamps"
  members = "lights in living or lights in hall"

If the members are exactly those of a group that a gateway keeps, a command to all of them is one message.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the groups")
    set_door_command(command, _list, _EXAMPLES)
    command.add_argument("--json", action="store_true", help="print a JSON list")
    command = add_verb(verbs, "show", "show the members of a group")
    set_door_command(command, _show, _EXAMPLES)
    command.add_argument("name", metavar="NAME", help="its name, or the id of a gateway's group")
    command.add_argument("--json", action="store_true", help="print a JSON list")


def _groups(door: DoorClient, name: str = "") -> tuple[GroupInfo, ...]:
    return cast("ListGroupsResponse", door.ask(LIST_GROUPS, {"name": name})).groups


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    groups = _groups(door)
    if options.json:
        print(list_text([json_text(fields_of(group)) for group in groups]))
    elif groups:
        rows = [(printable(group.name), _kind(group), str(len(group.members)), _message(group)) for group in groups]
        print_table(("GROUP", "OF", "MEMBERS", "ONE MESSAGE TO"), rows, if_any=("ONE MESSAGE TO",))
    else:
        print("there is no group; a table [[groups]] in homebot.toml makes one, see `homebot group --help`")
    return 0


def _show(door: DoorClient, options: argparse.Namespace) -> int:
    groups = _groups(door, options.name)
    if options.json:
        print(list_text([json_text(fields_of(group)) for group in groups]))
        return 0
    for group in groups:
        print_line(
            f"{printable(group.name)}, a group of {_kind(group)}{f': {printable(group.query)}' if group.query else ''}"
        )
        for member in group.members:
            print_line(f"  {printable(member.value)} ({printable(member.key)})")
        if not group.members:
            print_line("  no device is a member")
        if not group.is_complete:
            print_line("  its gateway lists members that homebot does not know, so each is told by itself")
        print_line(
            f"one message reaches all: {_message(group)}" if group.reached_by else "each member gets its own message"
        )
    return 0


def _kind(group: GroupInfo) -> str:
    return printable(group.id) if group.id else "homebot"


def _message(group: GroupInfo) -> str:
    return ", ".join(map(printable, group.reached_by))
