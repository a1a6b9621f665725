"""``homebot approve``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import named_device, unapproved
from homebot.cli.door_client import DoorClient, door_command
from homebot.devices.names import APPROVE_DEVICE
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.approval_messages import ApproveDeviceResponse

__all__ = ["add_arguments"]


_EXAMPLES = """\
  homebot approve 'Front door' --show      what would be approved, and nothing else
  homebot approve 'Front door'
  homebot approve 'Front door' --undo

Locks, garage doors, ovens, boilers, valves and alarm panels wait for this: until then nothing is sent to them.
`homebot devices` shows which ones wait. What is approved is printed: each setting, the topic and the payload. If the
device announces another type, topic, payload or identifier, it waits again. An approval outlasts a restart.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot approve``."""
    set_client_command(parser, _approve, _EXAMPLES, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--show", action="store_true", help="show what would be approved, and change nothing")
    action.add_argument("--undo", action="store_true", help="take the approval back")


@door_command
def _approve(door: DoorClient, options: argparse.Namespace) -> int:
    """Approve a device, take that back, or show what would be approved."""
    device = named_device(door, options.device).id
    waited = device in unapproved(door, device)
    answer = shown = _ask(door, device=device, is_preview=not options.undo, remove=options.undo)
    if not (options.undo or options.show):  # what is printed is what is approved, also of a device that keeps changing
        answer = _ask(door, device=device, digest=shown.digest)
    if options.show:
        print(f"{printable(device)} {'waits for approval' if waited else 'does not wait for approval'}; its commands:")
    else:
        print(f"{printable(device)} {_told(waited=waited, undo=options.undo)}")
    for change in answer.changes:
        print(f"  changed: {printable(change)}")
    for command in shown.commands:
        print(f"  {printable(command)}")
    return 0


def _ask(door: DoorClient, **request: object) -> ApproveDeviceResponse:
    return cast("ApproveDeviceResponse", door.ask(APPROVE_DEVICE, request))


def _told(*, waited: bool, undo: bool) -> str:
    if undo:
        return "is not approved any more"
    return "is approved" if waited else "is approved; it was not waiting for that"
