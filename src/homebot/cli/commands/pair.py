"""``homebot pair``."""

from __future__ import annotations

import argparse

from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities
from homebot.devices.names import PairingNames
from homebot.errors import PeerError, UsageError
from homebot.support.printable import printable

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot pair 'Hall lamp' 123-45-678     with the code on the device
  homebot pair 'Hue bridge'               after pressing the button on the device
  homebot pair --remove 'Hall lamp'

Some devices serve only programs that they are paired with. homebot keeps the key that this yields, in a file that only
its own user can read; the code is not kept. It takes the right `manage`. `homebot doctor` names devices that wait.
"""
_WITHIN = 90.0
"""Seconds; a sleeping device has to wake up, and some wait for a button."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot pair``."""
    set_door_command(parser, _pair, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("code", metavar="CODE", nargs="?", default="", help="the code on the device, if it has one")
    parser.add_argument("--remove", action="store_true", help="end the pairing")


def _pair(door: DoorClient, options: argparse.Namespace) -> int:
    if options.remove and options.code:
        raise UsageError("--remove takes no code")
    device = named_device(door, options.device)
    served = {one.name for one in entities(door, kind="service")}
    endpoint = next((one for one in device.endpoints if PairingNames(one.gateway).pair in served), None)
    if endpoint is None:
        raise PeerError(f"{printable(device.id)} needs no pairing: no running gateway that knows it pairs devices")
    names, request = PairingNames(endpoint.gateway), {"device": endpoint.key}
    if options.remove:
        answer = door.ask(names.unpair, request, _WITHIN)
    else:
        answer = door.ask(names.pair, request | {"code": options.code}, _WITHIN)
    print(f"{printable(str(answer.name))} is {'not paired any more' if options.remove else 'paired'}")
    return 0
