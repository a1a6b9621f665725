"""``homebot bind``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.door_client import DoorClient, set_door_command
from homebot.devices.names import CHANGE_ROUTINE, QUERY_DEVICES
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError, UsageError
from homebot.routines.text import routine_text
from homebot.support.printable import printable
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.part import Capability
    from homebot.devices.services import QueryDevicesResponse

__all__ = ["add_arguments"]

_EXAMPLES: Final = """\
  homebot bind 'Hall button' single 'hall lamp' toggle
  homebot bind 'Hall button' double scene Film
  homebot bind 'Hall button' hold 'hall lamp' dim       while it is held, at most 10 s; also brighten, darken
  homebot bind 'Hall button' any 'lights in hall' off

It writes a routine, which `homebot routine list`, `show`, `edit`, `disable` and `remove` know by the name of the button
and its event, and needs the right `manage`. `homebot show 'Hall button'` lists the events of a button.
"""

_ANY: Final = "any"
_DIMS: Final = frozenset({"dim", "brighten", "darken"})
_LONGEST: Final = 60.0
_MOST: Final = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _bind, _EXAMPLES)
    parser.add_argument("button", metavar="BUTTON", help="its name, or a query for it")
    parser.add_argument("event", metavar="EVENT", help="such as single, double or hold; `any` for each")
    parser.add_argument("step", metavar="STEP", nargs="+", help="devices and a command, as a step of a routine")


def _bind(door: DoorClient, options: argparse.Namespace) -> int:
    _check_event(door, options.button, options.event)
    event = "" if options.event == _ANY else f" {options.event}"
    step = " ".join(options.step)
    if options.step[-1] in _DIMS and options.step[0] != "scene":
        if not event:
            raise UsageError("say while which event it dims, such as hold")
        step = f"{step} while {options.button}{event}"
    text = routine_text({"name": f"{options.button}{event}", "when": [f"{options.button} press{event}"], "do": [step]})
    answer = door.call(CHANGE_ROUTINE, {"change": "new", "text": text}, timeout=_LONGEST)
    if not answer["success"]:
        raise PeerError(printable(str(answer["message"]), 2000))
    first, *hints = str(answer["message"]).splitlines()
    for line in (f"{first}: {step}", *hints):
        print(printable(line))
    return 0


def _check_event(door: DoorClient, button: str, event: str) -> None:
    """Check that a device fits *button*, and that one reports *event*, if any tells its events."""
    answer = cast("QueryDevicesResponse", JsonMessage(door.call(QUERY_DEVICES, {"query": button, "limit": _MOST})))
    if not answer.success:
        raise UsageError(answer.message)
    presses = _presses(answer)
    if not presses:
        raise UsageError(f"no button fits {button!r}; `homebot find buttons` shows those that there are")
    events = {option for can in presses for option in can.options}
    if event != _ANY and all(can.options for can in presses) and event.casefold() not in map(str.casefold, events):
        hint = did_you_mean(event, events, f"it has {', '.join(sorted(events))}")
        raise UsageError(f"{button} reports no {event!r}; {hint}")


def _presses(answer: QueryDevicesResponse) -> list[Capability]:
    parts = [part.part for one in answer.results for part in one.device.parts]
    return [can for part in parts for can in part.capabilities if can.name == "press" and can.readable]
