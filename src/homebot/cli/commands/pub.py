"""``homebot topic pub``."""

from __future__ import annotations

import argparse
import json
import re

import anyio

from homebot.cli.directory import no_such_topic, topic_type
from homebot.cli.door_client import DoorClient
from homebot.cli.publishing import GatewayPublisher
from homebot.cli.with_client import with_client

__all__ = ["pub"]

_OUT = re.compile(r"/?gateway/([^/]+)/out")


def pub(options: argparse.Namespace) -> int:
    """Publish a message as often as the options say; by default once a second until Ctrl-C."""

    async def run(door: DoorClient) -> int:
        ros_type = options.type or await topic_type(door, options.topic)
        if not ros_type:
            raise await no_such_topic(door, options.topic)
        gateway = _gateway_of(options.topic)
        outbox = GatewayPublisher(door) if gateway else None
        if outbox is not None:
            await outbox.check(gateway)
        await door.advertise(options.topic, ros_type)
        await door.settle()
        shown = json.dumps(options.value)
        number = 0
        due = anyio.current_time()
        while True:
            number += 1
            if outbox is None:
                await door.publish(options.topic, options.value)
                await door.settle()
            else:
                await outbox.send(gateway, options.value)
            print(f"publishing #{number} on {options.topic}: {shown}", flush=True)
            if number == options.times:
                return 0
            due = max(due + 1 / options.rate, anyio.current_time())
            await anyio.sleep_until(due)

    return with_client(options, run)


def _gateway_of(topic: str) -> str:
    """Return the gateway that takes commands on *topic*; empty where it is no such topic."""
    found = _OUT.fullmatch(topic)
    return found[1] if found else ""
