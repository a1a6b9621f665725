"""``homebot place``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import device_or_similar
from homebot.cli.door_client import DoorClient, with_client
from homebot.devices.names import PLACE_DEVICE
from homebot.errors import PeerError, UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.places_messages import PlaceDeviceResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot place 'Kitchen lamp' Kitchen
  homebot place 'Kitchen lamp' --at 3.2,1.0
  homebot place 'Kitchen lamp' --undo

A position is in metres, as in the polygons of rooms; without a ROOM the device is in the room that is there.

A device that is not there yet, by its name, id or hardware address (mac:a4cf12f04ab1), is placed when it appears. The
directory remembers it over a restart. It outranks the room that the device announces, and the one in the
configuration; `homebot show` tells who said what. `homebot places list` lists the rooms.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot place``."""
    set_client_command(parser, _place, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("room", nargs="?", default="", metavar="ROOM", help="the room or floor that it is in")
    parser.add_argument("--at", default="", metavar="X,Y[,FLOOR]", help="its position, in metres")
    parser.add_argument("--undo", action="store_true", help="take back what was said by this command or an import")
    parser.add_argument(
        "--new",
        action="store_true",
        help="ROOM, or a DEVICE not there yet, is not the one with a similar name",
    )


def _told(device: str, position: str, answer: PlaceDeviceResponse) -> str:
    room, absent = printable(answer.room), printable(answer.absent)
    where = " ".join([f"at {position}"] * bool(position) + [f"in {room}"] * bool(room))
    if absent:
        later = f"will be {where} when it appears" if where else "will be in no stated room"
        return f"there is no device {device} yet; {absent} {later}"
    if position and not room:
        return f"{device} is {where} now; its room is unknown"
    return f"{device} is {where} now" if where else f"the room of {device} is unknown now"


def _place(options: argparse.Namespace) -> int:
    """Set the room of a device, or take it back."""
    if options.undo is bool(options.room or options.at):
        raise UsageError("give either a ROOM, --at, or both, or --undo")

    def run(door: DoorClient) -> int:
        known = device_or_similar(door, options.device)
        if isinstance(known, list) and known and not options.undo and not options.new:
            hint = "For another one, which is not there yet, add --new"
            raise PeerError(f"there is no device {options.device}; did you mean {' or '.join(known)}? {hint}")
        device = options.device if isinstance(known, list) else known.id
        request = {
            "device": device,
            "room": options.room,
            "is_new": options.new,
            "may_be_absent": isinstance(known, list),
            "at": options.at,
        }
        try:
            answer = cast("PlaceDeviceResponse", door.ask(PLACE_DEVICE, request))
        except PeerError as exc:
            hint = "" if options.new or "did you mean" not in str(exc) else " For another room, add --new"
            raise PeerError(f"{exc}{hint}") from exc
        print(_told(printable(device), printable(options.at), answer))
        return 0

    return with_client(options, run)
