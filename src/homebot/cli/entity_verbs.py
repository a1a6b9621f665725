"""The commands shared by ``homebot topic``, ``service`` and ``action``: ``list``, ``type`` and ``find``."""

import argparse
from typing import Final

from homebot.cli.arguments import Commands, add_verb
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities, is_hidden, not_found
from homebot.cli.yaml import message, type_or_message
from homebot.errors import PeerError
from homebot.names import absolute_name
from homebot.support.similar import did_you_mean

__all__ = ["add_entity_verbs", "add_value_arguments", "check_type", "type_of"]

_ENDS: Final = {
    "topic": ("publisher", "subscription"),
    "service": ("service",),
    "action": ("action server", "action client"),
}


def add_entity_verbs(verbs: Commands, kind: str, name: str, ros_type: str) -> None:
    """Add the commands for *kind*, a key of the table above; *name* and *ros_type* are for the examples."""
    listed = add_verb(verbs, "list", f"list every {kind}")
    listed.add_argument("-t", "--show-types", action="store_true", help=f"show each {kind}'s type")
    set_door_command(listed, _list, f"  homebot {kind} list\n  homebot {kind} list -t\n")
    typed = add_verb(verbs, "type", f"print the type of one {kind}")
    typed.add_argument("name", metavar=kind.upper(), help=f"name of the {kind}")
    set_door_command(typed, _type, f"  homebot {kind} type {name}\n")
    found = add_verb(verbs, "find", f"list the {kind}s of a type")
    found.add_argument("type", metavar="TYPE", help=f"type of the {kind}s")
    set_door_command(found, _find, f"  homebot {kind} find {ros_type}\n")
    for command in (listed, typed, found):
        command.set_defaults(kind=kind, all=False)
    for command in (listed, found):
        command.add_argument("-a", "--all", action="store_true", help=f"show hidden {kind}s too")


def add_value_arguments(command: argparse.ArgumentParser, kind: str, value: str) -> None:
    """Add the name of a *kind*, and the type and fields of a *value* for it."""
    command.add_argument(kind, metavar=kind.upper(), help=f"name of the {kind}")
    command.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="expected type (default: any)"
    )
    command.add_argument(
        value, metavar=value.upper(), nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )


def type_of(door: DoorClient, kind: str, name: str) -> str:
    """Return the type of the *kind* called *name*.

    Raises:
        PeerError: There is none; names similar ones.
    """
    known = _types(door, kind, show_hidden=True)
    full_name = absolute_name(name)
    if full_name not in known:
        raise not_found(kind, full_name, known)
    return known[full_name]


def check_type(kind: str, name: str, ros_type: str, expected: str) -> None:
    """Check that *ros_type* is the *expected* one, if any, with or without its kind.

    Raises:
        PeerError: It is a different type.
    """
    if expected and _short(expected) != _short(ros_type):
        raise PeerError(f"{kind} {name} is a {ros_type}, not a {expected}")


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    for name, ros_type in _types(door, options.kind, show_hidden=options.all).items():
        print(f"{name} [{ros_type}]" if options.show_types else name)
    return 0


def _type(door: DoorClient, options: argparse.Namespace) -> int:
    print(type_of(door, options.kind, options.name))
    return 0


def _find(door: DoorClient, options: argparse.Namespace) -> int:
    kind, known = options.kind, _types(door, options.kind, show_hidden=options.all)
    found = [name for name, ros_type in known.items() if _short(ros_type) == _short(options.type)]
    if not found:
        hint = did_you_mean(options.type, {*known.values()}, f"`homebot {kind} list -t` shows the types of all")
        raise PeerError(f"there is no {kind} of type {options.type}; {hint}")
    print("\n".join(found))
    return 0


def _types(door: DoorClient, kind: str, *, show_hidden: bool) -> dict[str, str]:
    ends = [one for one in entities(door) if one.kind in _ENDS[kind] and (show_hidden or not is_hidden(one))]
    return {one.name: one.type for one in ends}


def _short(ros_type: str) -> str:
    package, _, name = ros_type.partition("/")
    return f"{package}/{name.rpartition('/')[2]}"
