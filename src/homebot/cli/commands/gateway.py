"""``homebot gateway``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.devices.names import RESTART_GATEWAY
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.bridges.rosapi.doctor import ExamineResponse

_EXAMPLES = """\
  homebot gateway list            the gateways, with their states
  homebot gateway restart mqtt    stop and start one, also one that crashed too often

`restart` needs the right `manage`. One that crashes five times within a minute is tried again after an hour.
"""

_MAX_WAIT_S = 60.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    set_door_command(add_verb(verbs, "list", "list the gateways"), _list, "  homebot gateway list\n")
    command = add_verb(verbs, "restart", "stop and start a gateway")
    set_door_command(command, _restart, _EXAMPLES)
    command.add_argument("gateway", metavar="NAME", help="its name: that of its table [gateways.NAME]")


def _list(door: DoorClient, _: argparse.Namespace) -> int:
    fields = door.call("/rosapi/doctor", {"gateways_only": True}, timeout=_MAX_WAIT_S)
    for gateway in cast("ExamineResponse", JsonMessage(fields)).gateways:
        print(printable(gateway.text, 1000))
    return 0


def _restart(door: DoorClient, options: argparse.Namespace) -> int:
    answer = door.call(RESTART_GATEWAY, {"gateway": options.gateway})
    text = printable(str(answer["message"]), 1000)
    if not answer["success"]:
        raise PeerError(text)
    print(text)
    return 0
