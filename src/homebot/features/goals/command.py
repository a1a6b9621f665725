"""``homebot achieve``."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_json import json_text
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.goals import perform_goal
from homebot.devices.wording.json_message import JsonMessage
from homebot.features.goals import ACHIEVE
from homebot.features.goals.step_words import step_text
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.features.goals.messages import AchieveFeedback, AchieveResult

_EXAMPLES = """\
  homebot achieve 'kitchen lit and rosie in kitchen' --dry-run
  homebot achieve 'hall dark and front door closed'

A wish is ROOM lit, ROOM dark, ROBOT in ROOM, or any query with a state, as for `homebot find`. The plan is shown before
it runs. Exit code 0 means that the goal is reached or, with --dry-run, would be; 1 that it is not, with the reason.
"""
_WIDEST: Final = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _achieve, _EXAMPLES, acts=True)
    parser.add_argument("goal", metavar="GOAL", help="wishes joined by `and`")
    parser.add_argument("--dry-run", action="store_true", help="print the plan only")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def _achieve(options: argparse.Namespace) -> int:
    shown: list[str] = []

    def show(values: Mapping[str, object]) -> None:
        nonlocal shown
        lines = list(_lines(cast("AchieveFeedback", JsonMessage(values))))
        for line in lines if not options.json else ():
            if line not in shown:
                print(line, flush=True)
        shown = lines

    def run(door: DoorClient, _: argparse.Namespace) -> int:
        values = perform_goal(
            door, ACHIEVE.name, ACHIEVE.ros_type, {"goal": options.goal, "is_dry_run": options.dry_run}, show
        )
        result = cast("AchieveResult", JsonMessage(values))
        print(json_text(values) if options.json else printable(result.message, _WIDEST))
        return 0 if result.success else 1

    return with_client(options, run)


def _lines(feedback: AchieveFeedback) -> Iterable[str]:
    for text in feedback.tried:
        yield f"tried: {printable(text, _WIDEST)}"
    for number, step in enumerate(feedback.steps, 1):
        yield f"{number}. {step_text(step)}"
