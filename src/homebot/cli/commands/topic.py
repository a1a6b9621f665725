"""``homebot topic``: ``list``, ``echo`` and ``pub``."""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections.abc import Collection
from typing import TYPE_CHECKING

from homebot.cli.arguments import Commands, add_verb, add_verbs, positive, seconds, whole
from homebot.cli.device_queries import find_devices
from homebot.cli.door_client import DoorClient, ReceivedMessage, set_door_command
from homebot.cli.graph_queries import (
    Schema,
    add_list_verb,
    message_schema,
    no_such_topic,
    not_yet,
    topic_type,
)
from homebot.cli.publishing import GatewayPublisher
from homebot.cli.yaml import message, to_yaml
from homebot.errors import PeerError
from homebot.support.printable import printable
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.devices import Device

_EXAMPLES = """\
  homebot topic list -t
  homebot topic echo /rosout
  homebot topic pub --once /hello std_msgs/String '{data: hi}'
"""
_ECHO_EXAMPLES = """\
  homebot topic echo /rosout
  homebot topic echo --once --field msg /rosout
  homebot topic echo --json --timeout 10 /discovery/changes
"""
_PUB_EXAMPLES = """\
  homebot topic pub --once /hello std_msgs/String '{data: hi}'
  homebot topic pub -r 5 -t 10 /hello std_msgs/String '{"data": "hi"}'
  homebot topic pub --once /gateway/mqtt/out '{address: home/lights/lamp1/in, payload: off}'
"""
_OUT = re.compile(r"/?gateway/([^/]+)/out")
_SMALL_HOUSE = 200


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    add_list_verb(verbs, "topic")
    command = add_verb(verbs, "echo", "print the messages of a topic")
    command.add_argument("topic", metavar="TOPIC", help="name of the topic, which need not exist yet")
    command.add_argument("--once", action="store_true", help="end after the first message")
    command.add_argument("--timeout", metavar="S", type=seconds, help="give up after S seconds without a message")
    command.add_argument("--field", metavar="A.B", help="print only this field")
    command.add_argument("--json", action="store_true", help="print each message as one line of JSON")
    set_door_command(command, _echo, _ECHO_EXAMPLES)
    _add_pub(verbs)


def _add_pub(verbs: Commands) -> None:
    command = add_verb(verbs, "pub", "publish on a topic")
    command.add_argument("topic", metavar="TOPIC", help="name of the topic")
    command.add_argument("type", metavar="TYPE", nargs="?", default="", help="type of the topic; needed for a new one")
    command.add_argument("value", metavar="VALUE", type=message, help="the message, as JSON or as {field: value}")
    count = command.add_mutually_exclusive_group()
    count.add_argument("-1", "--once", action="store_const", const=1, dest="times", help="publish once")
    count.add_argument("-t", "--times", metavar="N", type=whole, help="publish N times (default: until Ctrl-C)")
    command.add_argument(
        "-r", "--rate", metavar="HZ", type=positive, default=1.0, help="messages per second (default: 1)"
    )
    set_door_command(command, _pub, _PUB_EXAMPLES, acts=True)


def _echo(door: DoorClient, options: argparse.Namespace) -> int:
    door.subscribe(options.topic)
    schema = _schema(door, options.topic)
    while True:
        try:
            received = door.next(options.timeout)
        except TimeoutError:
            print(f"homebot: no message on {options.topic} within {options.timeout:g} s", file=sys.stderr)
            return 1
        if schema is None and not options.json:
            schema = message_schema(door, topic_type(door, options.topic))
        _show(received, schema, options)
        if options.once:
            return 0


def _schema(door: DoorClient, topic: str) -> Schema | None:
    """Return the message type of the topic; if it does not exist yet, say so and return None."""
    ros_type = topic_type(door, topic)
    if ros_type:
        return message_schema(door, ros_type)
    print(not_yet(door, topic), file=sys.stderr)
    return None


def _show(received: ReceivedMessage, schema: Schema | None, options: argparse.Namespace) -> None:
    if received.lost:
        print(f"homebot: {received.lost} messages before this one were lost: they came too fast", file=sys.stderr)
    fields = received.message if options.json or schema is None else schema.readable(received.message)
    value = _field(fields, options.field) if options.field else fields
    text = f"{json.dumps(value)}\n" if options.json else f"{to_yaml(value)}---\n"
    print(text, end="", flush=True)


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


def _pub(door: DoorClient, options: argparse.Namespace) -> int:
    """Publish a message repeatedly; by default once a second until Ctrl-C."""
    ros_type = options.type or topic_type(door, options.topic)
    if not ros_type:
        raise no_such_topic(door, options.topic)
    gateway = match[1] if (match := _OUT.fullmatch(options.topic)) else ""
    publisher = GatewayPublisher(door) if gateway else None
    if publisher is not None:
        publisher.check(gateway)
    door.advertise(options.topic, ros_type)
    door.settle()
    shown = json.dumps(options.value)
    number = 0
    due = time.monotonic()
    while True:
        number += 1
        if publisher is None:
            door.publish(options.topic, options.value)
            door.settle()
        else:
            publisher.send(gateway, options.value)
            if number == 1:
                _warn_of_unknown_address(door, options.value)
        print(f"publishing #{number} on {options.topic}: {shown}", flush=True)
        if number == options.times:
            return 0
        due = max(due + 1 / options.rate, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))


def _warn_of_unknown_address(door: DoorClient, command: dict[str, object]) -> None:
    """Warn if no device takes commands on the address of *command*; a large house is not searched."""
    page = find_devices(door, "", _SMALL_HOUSE)
    address = command.get("address")
    if not isinstance(address, str) or not page.results or page.total > _SMALL_HOUSE:
        return
    known = _command_addresses([result.device for result in page.results])
    if address not in known:
        hint = did_you_mean(address, known - {""}, "it is published anyway", cutoff=0.8)
        print(f"homebot: no known device takes commands on {printable(address)}; {hint}", file=sys.stderr)


def _command_addresses(devices: Collection[Device]) -> set[str]:
    known = {end.command_address for device in devices for end in device.endpoints}
    return known | {topic for device in devices for part in device.parts for topic in part.part.writes}
