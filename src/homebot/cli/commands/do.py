"""``homebot do``."""

from __future__ import annotations

import argparse
import getpass
import shlex
from functools import partial
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import duration, set_client_command
from homebot.cli.device_json import json_text
from homebot.cli.door_client import DoorClient, with_client
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.outcomes import Superseded, has_succeeded
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.command_messages import CommandDevicesResponse

_EXAMPLES = """\
  homebot do 'Kitchen lamp' on
  homebot do 'lamp near robot' toggle
  homebot do 'light in hall' 'warm white'
  homebot do everything off
  homebot do 'light in hall' on --level 40 --transition 3
  homebot do 'window covering' close
  homebot do Heating heating_setpoint 21
  homebot do 'Front door' unlock --ask-code

`near robot` commands the nearest device that may be commanded; `within 5 m of robot` commands all of them. Exit code 0
means that every device obeyed, or was already as commanded; 1 that one was not. For several devices the last line has
the worst outcome. The home in the answer is that of the homebot that carried out the command.
"""

_WIDEST: Final = 1000
"""The limit of characters of an outcome: a refusal ends with its remedy."""

_MAX_WAIT_S: Final = 900.0
"""Seconds; homebot answers sooner, after the usual response time of the slowest device."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _do, _EXAMPLES, acts=True)
    parser.add_argument("target", metavar="QUERY", help="the id or name of a device, or a query as for `homebot find`")
    parser.add_argument(
        "word", metavar="COMMAND", help="a word such as on, off, toggle, open, lock, red, or a capability such as level"
    )
    parser.add_argument("values", metavar="VALUE", nargs="*", default=[], help="the value of a capability")
    parser.add_argument("--level", metavar="PERCENT", help="brightness, above 0 and up to 100")
    parser.add_argument("--kelvin", metavar="K", help="colour temperature")
    parser.add_argument(
        "--color", metavar="COLOR", help="a name such as red, or hue to 360 and saturation to 100: 0,100"
    )
    parser.add_argument("--override", action="store_true", help="also if a robot or an app holds it, as by hand")
    parser.add_argument("--ask-code", action="store_true", help="ask for the code of a lock or an alarm")
    add_options_of_commands(parser)


def add_options_of_commands(parser: argparse.ArgumentParser) -> None:
    """Add the options of :func:`command_house`, and the transition."""
    parser.add_argument(
        "--transition",
        metavar="TIME",
        type=partial(duration, most=86_400),
        default=0.0,
        help="seconds that the change takes, or a time such as 500ms",
    )
    parser.add_argument("--json", action="store_true", help="print the answer of homebot as JSON")


def _do(options: argparse.Namespace) -> int:
    given = {"level": options.level, "color_temperature": options.kelvin, "color": options.color}
    values = {name: value for name, value in given.items() if value is not None}
    command = options.word
    if command.lstrip("+-")[:1].isdecimal() or command in {"arm", "brighter", "darker"}:  # perhaps with a unit
        command = " ".join([command, *options.values])
    elif options.values:
        values[command] = " ".join(options.values)
    if command in values:
        command = "set"
    request = {
        "target": options.target,
        "command": command,
        "values": [{"key": name, "value": value} for name, value in values.items()],
        "transition": options.transition,
        "override": options.override,
        "code": getpass.getpass("code: ") if options.ask_code else "",
    }
    return with_client(options, lambda door, _: command_house(door, options, COMMAND_DEVICES, request))


def command_house(door: DoorClient, options: argparse.Namespace, service: str, request: dict[str, object]) -> int:
    """Send *request* to a *service* for commands, print the outcomes, and return the exit code."""
    answer = cast("CommandDevicesResponse", JsonMessage(door.call(service, request, _MAX_WAIT_S)))
    if options.json:
        print(json_text(fields_of(answer)))
    else:
        _print_outcomes(answer, printable(door.home))
    return 0 if answer.success else 1


def _print_outcomes(answer: CommandDevicesResponse, home: str) -> None:
    """Print each outcome of a command in *home*, and last the worst of several.

    Raises:
        PeerError: Nothing was commanded; it says why.
    """
    count = len(answer.results)
    if not count and not answer.success:
        raise PeerError(answer.message)
    if not count:
        print(printable(answer.message))
        return
    where = f" in {home}"
    for result in answer.results:
        place = where if count == 1 else ""
        text = result.result.text
        if result.result.outcome == Superseded.kind:
            text += f"; `homebot why {shlex.quote(result.name)}` names its issuer"
        if result.result.policy == "lease":
            text += "; `--override` commands it all the same, as by hand"
        print(f"{printable(result.name)}{place}: {printable(text, _WIDEST)}")
    if count > 1:
        done = sum(has_succeeded(result.result.outcome) for result in answer.results)
        worst = f"; worst outcome: {answer.outcome.replace('_', ' ')}" if done < count else ""
        print(f"{done} of {count}{where} succeeded{worst}")
