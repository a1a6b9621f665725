"""``homebot place``."""

from __future__ import annotations

import argparse
from typing import cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.records import PlaceResponseRecord
from homebot.cli.table import printable
from homebot.devices.names import PLACE_DEVICE
from homebot.errors import PeerError, UsageError

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot place 'Kitchen lamp' Kitchen
  homebot place 'Kitchen lamp' --undo

The directory remembers it over a restart. It outranks the room that the device announces, and the one in the
configuration; `homebot show` tells who said what. `homebot places list` lists the rooms.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot place``."""
    set_client_command(parser, _place, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("room", nargs="?", default="", metavar="ROOM", help="the room or floor that it is in")
    parser.add_argument("--undo", action="store_true", help="take back what was said by this command or an import")
    parser.add_argument("--new", action="store_true", help="ROOM is new, although its name is like that of another")


def _place(options: argparse.Namespace) -> int:
    """Set the room of a device, or take it back."""
    if options.undo is bool(options.room):
        raise UsageError("give either a ROOM or --undo")

    def run(door: DoorClient) -> int:
        device = named_device(door, options.device)["id"]
        request = {"device": device, "room": options.room, "is_new": options.new}
        answer = cast("PlaceResponseRecord", door.call(PLACE_DEVICE, request))
        if not answer["success"]:
            raise PeerError(answer["message"])
        room = printable(answer["room"])
        print(f"{printable(device)} is in {room} now" if room else f"the room of {printable(device)} is unknown now")
        return 0

    return with_client(options, run)
