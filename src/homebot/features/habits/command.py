"""``homebot suggest``."""

from __future__ import annotations

import argparse
from datetime import datetime
from functools import partial
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import whole
from homebot.cli.device_json import json_text, list_text
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.local_time import zone_of
from homebot.cli.terminal import print_line
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.devices.wording.time_format import age_text
from homebot.errors import PeerError, UsageError
from homebot.features.habits import DECIDE_HABIT, SUGGEST_HABITS
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.features.habits.messages import HabitOccasion, SuggestHabitsResponse

_EXAMPLES: Final = """\
  homebot suggest                     what people did again and again in the last 28 days, as routines
  homebot suggest --days 40 --each    the same of 40 days, with each occasion
  homebot suggest accept 2            keep and enable the second as a routine, which `homebot routine` knows
  homebot suggest reject 2            never propose it again

It reads the history and the journal; it changes nothing and sends nothing. `accept` and `reject` need the right
`manage`.
"""

_MAX_WAIT_S: Final = 120.0
_MAX_DAYS: Final = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _suggest, _EXAMPLES)
    parser.add_argument("decision", metavar="accept|reject", nargs="?", choices=("accept", "reject"), help="what to do")
    parser.add_argument("number", metavar="N", nargs="?", type=int, help="the number of a proposal")
    days = partial(whole, most=_MAX_DAYS)
    parser.add_argument("--days", type=days, default=28, metavar="N", help=f"1 to {_MAX_DAYS}; default: 28")
    parser.add_argument("--each", action="store_true", help="print each occasion")
    parser.add_argument("--json", action="store_true", help="print a JSON list")


def _suggest(door: DoorClient, options: argparse.Namespace) -> int:
    fields = door.call(SUGGEST_HABITS.name, {"days": options.days}, timeout=_MAX_WAIT_S)
    answer = cast("SuggestHabitsResponse", JsonMessage(fields))
    if not answer.success:
        raise PeerError(printable(answer.message, 2000))
    if options.decision:
        return _decide(door, options, answer)
    if options.json:
        print(list_text([json_text(fields_of(proposal)) for proposal in answer.proposals]))
        return 0
    for number, proposal in enumerate(answer.proposals, 1):
        print_line(f"{number:>2}  {printable(proposal.name)}")
        if proposal.conditions:
            print_line(f"     if {printable(' and '.join(proposal.conditions))}")
        print_line(f"     {printable(proposal.proof, 500)}")
        for occasion in proposal.occasions if options.each else ():
            print_line(f"     {_occasion(occasion, answer)}")
    if not answer.proposals:
        print(f"nothing to propose: {answer.searched:,} changes and presses, {answer.by_persons:,} of them by persons")
    for name in answer.watched:
        print_line(f"    watching: {printable(name)}")
    if answer.unnamed:
        print(f"left out: {answer.unnamed} devices without a name of their own; `homebot alias` gives one")
    return 0


def _occasion(occasion: HabitOccasion, answer: SuggestHabitsResponse) -> str:
    at, done_at = (stamp.sec + stamp.nanosec / 1e9 for stamp in (occasion.at, occasion.done_at))
    when = datetime.fromtimestamp(at, zone_of(answer.zone))
    if not done_at:
        return f"{when:%a %d %b %H:%M}  you did not"
    return f"{when:%a %d %b %H:%M}  you did, {age_text(abs(done_at - at))} {'later' if done_at >= at else 'before'}"


def _decide(door: DoorClient, options: argparse.Namespace, answer: SuggestHabitsResponse) -> int:
    count = len(answer.proposals)
    if options.number is None or not 1 <= options.number <= count:
        raise UsageError(f"say which: a number from 1 to {count}" if count else "there is nothing to propose")
    request = {"id": answer.proposals[options.number - 1].id, "accept": options.decision == "accept"}
    decided = door.call(DECIDE_HABIT.name, request, timeout=_MAX_WAIT_S)
    text = printable(str(decided["message"]), 2000)
    if not decided["success"]:
        raise PeerError(text)
    print(text)
    return 0
