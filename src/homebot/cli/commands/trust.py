"""``homebot trust``."""

from __future__ import annotations

import argparse
from typing import cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import TRUST_DEVICE
from homebot.support.printable import printable

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot trust 'Hall lamp'

For a device that is contradicted by a sensor although it obeys, for example since it was repaired. It is trusted again
by itself once the sensor sees it obey. It takes the right `manage`. `homebot doctor` names such devices.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot trust``."""
    set_client_command(parser, _trust, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")


@door_command
def _trust(door: DoorClient, options: argparse.Namespace) -> int:
    """Forget that a sensor contradicted a device."""
    device = named_device(door, options.device).id
    witnesses = cast("list[str]", door.call(TRUST_DEVICE, {"device": device})["witnesses"])
    for name in witnesses:
        print(f"{printable(device)} is trusted again; {printable(name)} had measured no change")
    if not witnesses:
        print(f"{printable(device)} was trusted already")
    return 0
