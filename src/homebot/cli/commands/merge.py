"""``homebot merge``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import MERGE_DEVICES
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.services import MergeDevicesResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot merge 'Kitchen lamp' 'Kitchen lamp 2'
  homebot merge 'Kitchen lamp'                    # let all its endpoints have its commands (homebot show)

The directory remembers it over a restart; `homebot split` undoes it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot merge``."""
    set_client_command(parser, _merge, _EXAMPLES, acts=True)
    parser.add_argument(
        "devices",
        nargs="+",
        metavar="DEVICE",
        help="ids or names of two or more devices, or of one whose endpoints are all its own",
    )


@door_command
def _merge(door: DoorClient, options: argparse.Namespace) -> int:
    """Make several devices one."""
    ids = [named_device(door, one).id for one in options.devices]
    answer = cast("MergeDevicesResponse", door.ask(MERGE_DEVICES, {"devices": ids}))
    if len(ids) == 1:
        print(f"all endpoints of {printable(answer.device)} may have its commands now")
    else:
        print(f"{', '.join(map(printable, ids))} are one device now: {printable(answer.device)}")
    return 0
