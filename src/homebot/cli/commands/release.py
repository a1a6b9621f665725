"""``homebot release``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import END_LEASES
from homebot.devices.wording.journal_words import issuer_text, settings_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.lease_messages import LeasesResponse

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot release 'Front door'

Ends all leases of a device, whoever holds it; `homebot leases` shows them. It takes the right `manage`. The device
stays as it is. A program whose lease was ended does not get the same one again: its block goes on without it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot release``."""
    set_client_command(parser, _release, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")


@door_command
def _release(door: DoorClient, options: argparse.Namespace) -> int:
    """End all leases of a device."""
    device = named_device(door, options.device).id
    parts = cast("LeasesResponse", JsonMessage(door.call(END_LEASES, {"device": device, "issuer": ""}))).parts
    for held in parts:
        for one in held.holders:
            who = f"{printable(one.by, 60)} ({issuer_text(one.issuer)})"
            print(f"{printable(device)} is no longer held {settings_text([held.setting])} by {who}")
    if not parts:
        raise PeerError(f"nobody holds {printable(device)}")
    return 0
