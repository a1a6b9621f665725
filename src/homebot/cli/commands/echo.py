"""``homebot topic echo``."""

from __future__ import annotations

import argparse
import json
import sys

import anyio

from homebot.cli.directory import WAITING, no_such_topic, topic_type
from homebot.cli.door_client import DoorClient, ReceivedMessage
from homebot.cli.schema import Schema, message_schema
from homebot.cli.with_client import with_client
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError

__all__ = ["echo"]


def echo(options: argparse.Namespace) -> int:
    """Print the messages of a topic, until Ctrl-C or as the options say."""

    async def run(door: DoorClient) -> int:
        await door.subscribe(options.topic)
        schema = await _schema(door, options.topic)
        while True:
            with anyio.move_on_after(options.timeout) as limit:
                delivery = await door.next()
            if limit.cancelled_caught:
                print(f"homebot: no message on {options.topic} within {options.timeout:g} s", file=sys.stderr)
                return 1
            if schema is None and not options.json:
                schema = await message_schema(door, await topic_type(door, options.topic))
            _show(delivery, schema, options)
            if options.once:
                return 0

    return with_client(options, run)


async def _schema(door: DoorClient, topic: str) -> Schema | None:
    """Return what the topic carries; where it does not exist yet, say so and return None."""
    ros_type = await topic_type(door, topic)
    if ros_type:
        return await message_schema(door, ros_type)
    print(f"homebot: {await no_such_topic(door, topic)}\n{WAITING}", file=sys.stderr)
    return None


def _show(delivery: ReceivedMessage, schema: Schema | None, options: argparse.Namespace) -> None:
    if delivery.lost:
        print(f"homebot: {delivery.lost} messages were lost before this one, as they came too fast", file=sys.stderr)
    message = delivery.message if options.json or schema is None else schema.readable(delivery.message)
    value = _field(message, options.field) if options.field else message
    text = f"{json.dumps(value)}\n" if options.json else f"{to_yaml(value)}---\n"
    print(text, end="", flush=True)


def _field(message: dict[str, object], path: str) -> object:
    value: object = message
    for part in path.split("."):
        if isinstance(value, list) and part.isdigit() and int(part) < len(value):
            value = value[int(part)]
        elif isinstance(value, dict) and part in value:
            value = value[part]
        else:
            known = f"; it has {', '.join(value)}" if isinstance(value, dict) and value else ""
            raise PeerError(f"the message has no field {path!r}: {part!r} is not there{known}")
    return value
