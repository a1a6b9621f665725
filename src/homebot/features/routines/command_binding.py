"""``homebot bind``."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Final, NamedTuple, cast

from homebot.cli.door_client import DoorClient, set_door_command
from homebot.devices.names import CHANGE_ROUTINE, QUERY_DEVICES
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError, UsageError
from homebot.support.folding import fold
from homebot.support.printable import printable
from homebot.words.routine_text import routine_text
from homebot.words.tokens import quoted
from homebot.words.triggers import Press, button_names, read_press

if TYPE_CHECKING:
    from homebot.devices import DevicePart
    from homebot.devices.services import QueryDevicesResponse

_EXAMPLES: Final = """\
  homebot bind 'Hall button' single 'hall lamp' toggle
  homebot bind 'Hall button' double scene Film
  homebot bind 'Hall button' hold 'hall lamp' dim       while it is held, at most 10 s; also brighten, darken
  homebot bind 'Hall button' any 'lights in hall' off
  homebot bind 'Dimmer#2' single 'hall lamp' off        the second button of a device with several

It writes a routine, which `homebot routine list`, `show`, `edit`, `disable` and `remove` know by the name of the button
and its event, and needs the right `manage`. `homebot show 'Hall button'` lists the events of a button.
"""

_ANY: Final = "any"
_DIMS: Final = frozenset({"dim", "brighten", "darken"})
_MAX_WAIT_S: Final = 60.0
_MAX_EVENTS: Final = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _bind, _EXAMPLES)
    parser.add_argument("button", metavar="BUTTON", help="its name, or a query for it")
    parser.add_argument("event", metavar="EVENT", help="such as single, double or hold; `any` for each")
    parser.add_argument("step", metavar="STEP", nargs="+", help="devices and a command, as a step of a routine")


def _bind(door: DoorClient, options: argparse.Namespace) -> int:
    button = _button(door, options.button, options.event)
    event = f" {options.event}" if options.event.replace("_", "").isalnum() else f" '{options.event}'"
    event = "" if options.event == _ANY else event
    step = " ".join(options.step)
    if options.step[-1] in _DIMS and options.step[0] != "scene":
        if not event:
            raise UsageError("say while which event it dims, such as hold")
        step = f"{step} while {button}{event}"
    name = f"{options.button} {options.event}".removesuffix(f" {_ANY}")
    text = routine_text({"name": name, "when": [f"{button} press{event}"], "do": [step]})
    answer = door.call(CHANGE_ROUTINE, {"change": "new", "text": text}, timeout=_MAX_WAIT_S)
    if not answer["success"]:
        raise PeerError(printable(str(answer["message"]), 2000))
    first, *hints = str(answer["message"]).splitlines()
    for line in (f"{first}: {step}", *hints):
        print(printable(line))
    return 0


class _Button(NamedTuple):
    """A part that tells of presses, and the id and the name of its device."""

    device: str
    name: str
    part: DevicePart
    events: tuple[str, ...]

    def may_tell(self, event: str) -> bool:
        """Return whether it tells of *event*, or does not say of which it does."""
        return event == _ANY or not self.events or fold(event) in map(fold, self.events)


def _button(door: DoorClient, text: str, event: str) -> str:
    """Return the words for the button *text*, which is known to report *event*, or does not tell its events."""
    press = read_press(f"{text} press")
    query, number, part = text.rpartition("#") if press and press.part else (text, "", "")
    found = _buttons(door, query)
    if (own := [one for one in found if fold(one.name) == fold(query)]) and len(own) < len(found):
        found, query = own, f"name={quoted(query)}"
    devices = groupby(found, key=lambda button: button.device)
    named = [one for _, group in devices for one in _chosen([*group], press)]
    if not named:
        raise UsageError(f"there is no {text}; name one of {_numbered(found)}")
    _check_event(named, text, event)
    return f"{query}{number}{part}"


def _chosen(buttons: list[_Button], press: Press | None) -> list[_Button]:
    """Return which of *buttons*, those of one device, *press* names."""
    if press is None:
        return buttons
    parts = press.buttons([button.part for button in buttons])
    return [button for button in buttons if button.part in parts]


def _check_event(named: Sequence[_Button], text: str, event: str) -> None:
    """Refuse *event* unless a button of *named* may tell of it, and no other button of its device."""
    telling = [one for one in named if one.may_tell(event)]
    if not telling:
        events = dict.fromkeys(option for one in named for option in one.events)
        raise UsageError(f"{text} reports no {event!r}; it has {', '.join(events)}")
    if len({fold(one.name) for one in telling}) == 1 < len(telling):
        raise UsageError(f"{text} means {len(telling)} buttons; name one of {_numbered(telling)}")


def _buttons(door: DoorClient, query: str) -> list[_Button]:
    answer = cast("QueryDevicesResponse", JsonMessage(door.call(QUERY_DEVICES, {"query": query, "limit": _MAX_EVENTS})))
    if not answer.success:
        raise UsageError(answer.message)
    found = [
        _Button(result.device.id, result.device.name or result.device.id, part, can.options)
        for result in answer.results
        for part in result.device.parts
        for can in part.part.capabilities
        if can.name == "press"
    ]
    if not found:
        raise UsageError(f"no button fits {query!r}; `homebot find buttons` shows those that there are")
    return found


def _numbered(buttons: Sequence[_Button]) -> str:
    """Return what names each of *buttons*; by ids where names are equal."""
    devices = [[*group] for _, group in groupby(buttons, key=lambda button: button.device)]
    counts = Counter(fold(group[0].name) for group in devices)
    return ", ".join(
        f"'{group[0].name if counts[fold(group[0].name)] == 1 else f'id={quoted(group[0].device)}'}"
        f"{f'#{name}' if name else ''}'"
        for group in devices
        for name in button_names(button.part for button in group)
    )
