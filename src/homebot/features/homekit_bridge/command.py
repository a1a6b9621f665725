"""``homebot homekit``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.devices.wording.json_message import JsonMessage
from homebot.features.homekit_bridge import GET_PAIRING, UNPAIR
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.features.homekit_bridge.messages import HomekitPairingResponse, HomekitUnpairResponse

_EXAMPLES = """\
  homebot homekit pairing      the code to scan with an iPhone: Home, +, Add Accessory; and what is there
  homebot homekit unpair       end all pairings, and take another code

The table [homekit_bridge] of homebot.toml says what Apple Home gets. Both need the right `manage`.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "pairing", "show the code that pairs the house with Apple Home, and what is there")
    set_door_command(command, _pairing, _EXAMPLES)
    command = add_verb(verbs, "unpair", "end all pairings with controllers of HomeKit")
    set_door_command(command, _unpair, _EXAMPLES)


def _pairing(door: DoorClient, _: argparse.Namespace) -> int:
    from homebot.cli.new_home import qr_code  # noqa: PLC0415 - it knows how homes begin

    answer = cast("HomekitPairingResponse", JsonMessage(door.call(GET_PAIRING.name, {})))
    for bridge in answer.bridges:
        print(f"{printable(bridge.name)} on {printable(bridge.address)}, port {bridge.port}")
        if bridge.code:
            print(f"\n{qr_code(bridge.uri)}\n  {bridge.code}\n\nnot paired: in Home, + and Add Accessory, scan this")
        else:
            print(f"paired with {bridge.controllers} controllers; `homebot homekit unpair` ends that")
        print(f"{len(bridge.accessories)} accessories: {', '.join(map(printable, bridge.accessories))}")
    for pair in answer.left_out:
        print(f"left out: {printable(pair.key)}: {printable(pair.value)}")
    if answer.message:
        print(printable(answer.message))
    return 0 if answer.success else 1


def _unpair(door: DoorClient, _: argparse.Namespace) -> int:
    answer = cast("HomekitUnpairResponse", JsonMessage(door.call(UNPAIR.name, {})))
    print(printable(answer.message) or f"{answer.controllers} pairings ended; remove the bridge in Home, too")
    return 0 if answer.success else 1
