"""``homebot alias``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import ALIAS_DEVICE
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.places_messages import AliasDeviceResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot alias lights/roomlights405 'Ceiling lamp'
  homebot alias 'Ceiling lamp' 'Ceiling lamp' --undo

The newest alias is the name that is shown; the device is still found by its other names. The directory remembers it
over a restart.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot alias``."""
    set_client_command(parser, _alias, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("name", metavar="NAME", help="the further name")
    parser.add_argument("--undo", action="store_true", help="take the name back")


@door_command
def _alias(door: DoorClient, options: argparse.Namespace) -> int:
    """Give a device a further name, or take it back."""
    device = named_device(door, options.device).id
    request = {"device": device, "alias": options.name, "remove": options.undo}
    answer = cast("AliasDeviceResponse", door.ask(ALIAS_DEVICE, request))
    aliases = ", ".join(map(printable, answer.aliases)) or "none"
    print(f"aliases of {printable(device)}: {aliases}")
    return 0
