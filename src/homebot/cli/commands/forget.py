"""``homebot forget``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.cli.publishing import GatewayPublisher
from homebot.devices.names import FORGET_DEVICE
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.services import ForgetDeviceResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot forget lights/roomlights405
  homebot forget 'Kitchen lamp' --purge

A forgotten device comes back when it sends a message or is announced again.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot forget``."""
    set_client_command(parser, _forget, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument(
        "--purge",
        action="store_true",
        help="also delete its retained announcements from the broker, so that no program finds it any more",
    )


@door_command
def _forget(door: DoorClient, options: argparse.Namespace) -> int:
    """Take a device out of the index, and on request its announcements off the broker."""
    device = named_device(door, options.device)
    publisher = GatewayPublisher(door)
    if options.purge:  # before anything is done, so that nothing is done by halves
        for gateway in sorted({one.gateway for one in device.endpoints}):
            publisher.check(gateway)
    answer = cast("ForgetDeviceResponse", door.ask(FORGET_DEVICE, {"device": device.id}))
    returns = "" if options.purge else "; it comes back when it sends a message or is announced again"
    print(f"forgot {printable(device.id)}{returns}")
    for one in answer.announced_on:
        topic = printable(one.topic)
        if options.purge:
            publisher.publish(one.gateway, one.topic, "", retain=True)
            print(f"deleted the retained message on {topic}")
        else:
            print(f"it was announced on {topic}; --purge deletes the retained message there")
    return 0
