"""``homebot split``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import SPLIT_DEVICE
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.services import SplitDeviceResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot show 'Kitchen lamp'                     # lists its announcements, and why they are one device
  homebot split 'Kitchen lamp'                    # each of them is a device of its own
  homebot split 'Kitchen lamp' mdns Lamp._wled._tcp.local.    # only this one is another device

The directory remembers it over a restart; `homebot merge` undoes it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot split``."""
    set_client_command(parser, _split, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("gateway", nargs="?", default="", metavar="GATEWAY", help="the gateway of one announcement")
    parser.add_argument("key", nargs="?", default="", metavar="KEY", help="what that gateway calls it")


@door_command
def _split(door: DoorClient, options: argparse.Namespace) -> int:
    """Make several devices of one."""
    device = named_device(door, options.device).id
    request = {"device": device, "gateway": options.gateway, "key": options.key}
    answer = cast("SplitDeviceResponse", door.ask(SPLIT_DEVICE, request))
    ids = [printable(one) for one in answer.devices]
    print(f"{ids[0]} is {len(ids)} devices now: {', '.join(ids)}")
    return 0
