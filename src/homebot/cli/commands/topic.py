"""``homebot topic``: ``list`` and ``echo``."""

from __future__ import annotations

import argparse
import json

from homebot.cli.arguments import add_verb, add_verbs, seconds
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import Schema, entities, not_yet, typedefs
from homebot.cli.remarks import print_error, remark
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError
from homebot.names import is_hidden

_EXAMPLES = """\
  homebot topic list -t
  homebot topic echo /rosout
"""
_ECHO_EXAMPLES = """\
  homebot topic echo /rosout
  homebot topic echo --once --field msg /rosout
  homebot topic echo --json --timeout 10 /discovery/changes
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list every topic")
    command.add_argument("-t", "--show-types", action="store_true", help="show each topic's type")
    command.add_argument("-a", "--all", action="store_true", help="show hidden topics too")
    set_door_command(command, _list, "  homebot topic list\n  homebot topic list -t\n")
    command = add_verb(verbs, "echo", "print the messages of a topic")
    command.add_argument("topic", metavar="TOPIC", help="name of the topic, which need not exist yet")
    command.add_argument("--once", action="store_true", help="end after the first message")
    command.add_argument("--timeout", metavar="S", type=seconds, help="give up after S seconds without a message")
    command.add_argument("--field", metavar="A.B", help="print only this field")
    command.add_argument("--json", action="store_true", help="print each message as one line of JSON")
    set_door_command(command, _echo, _ECHO_EXAMPLES)


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    known = {
        entity.name: (entity.type, "") for entity in entities(door) if entity.kind in {"publisher", "subscription"}
    }
    elsewhere: dict[str, tuple[str, list[str]]] = {}
    for entity in entities(door, kind="publisher", elsewhere=True):
        elsewhere.setdefault(entity.name, (entity.type, []))[1].append(entity.node)
    for name, (ros_type, nodes) in elsewhere.items():
        known[name] = known.get(name, (ros_type, ""))[0], f"  (at {', '.join(nodes)})"
    for name, (ros_type, place) in sorted(known.items()):
        if options.all or not is_hidden(name):
            print(f"{name} [{ros_type}]{place}" if options.show_types else f"{name}{place}")
    return 0


def _echo(door: DoorClient, options: argparse.Namespace) -> int:
    door.subscribe(options.topic)
    schema = _schema(door, options.topic)
    if schema is None:
        remark(not_yet(door, options.topic), as_json=options.json)
    while True:
        try:
            received = door.next(options.timeout)
        except TimeoutError:
            print_error(f"no message on {options.topic} within {options.timeout:g} s", as_json=options.json)
            return 1
        if schema is None and not options.json:
            schema = _schema(door, options.topic)
        if received.lost:
            remark(f"{received.lost} messages before this one were lost: they came too fast", as_json=options.json)
        fields = received.message if options.json or schema is None else schema.readable(received.message)
        value = _field(fields, options.field) if options.field else fields
        text = f"{json.dumps(value)}\n" if options.json else f"{to_yaml(value)}---\n"
        print(text, end="", flush=True)
        if options.once:
            return 0


def _schema(door: DoorClient, topic: str) -> Schema | None:
    """Return the message type of the topic; None if it does not exist yet."""
    ros_type = str(door.call("/rosapi/topic_type", {"topic": topic})["type"])
    return Schema(typedefs(door, "/rosapi/message_details", ros_type)) if ros_type else None


def _field(fields: dict[str, object], path: str) -> object:
    value: object = fields
    for part in path.split("."):
        if isinstance(value, list) and part.isdigit() and int(part) < len(value):
            value = value[int(part)]
        elif isinstance(value, dict) and part in value:
            value = value[part]
        else:
            known = f"; it has {', '.join(value)}" if isinstance(value, dict) and value else ""
            raise PeerError(f"the message has no field {path!r}: {part!r} is not there{known}")
    return value
