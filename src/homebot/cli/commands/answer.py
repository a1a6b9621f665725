"""``homebot answer``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, cast

from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_table
from homebot.devices.names import ANSWER_QUESTION, GET_QUESTIONS
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age_text, to_seconds
from homebot.errors import UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.question_messages import OpenQuestions

_EXAMPLES = """\
  homebot answer
  homebot answer 6926f1a3-14 yes

The first lists the questions that wait: what a program with the right `ask` wants to do, which is not done before a
person says yes. You answer what you could do yourself without being asked; who asks cannot answer.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _answer, _EXAMPLES)
    parser.add_argument("question", metavar="ID", nargs="?", default="", help="the question")
    parser.add_argument(
        "answer", metavar="yes|no", nargs="?", default="", choices=("", "yes", "no"), help="your answer"
    )


def _answer(door: DoorClient, options: argparse.Namespace) -> int:
    if not options.question:
        questions, now = cast("OpenQuestions", JsonMessage(door.call(GET_QUESTIONS))).questions, house_time(door)
        if questions:
            rows = [
                (question.question, printable(question.text, 300), age_text(to_seconds(question.until) - now))
                for question in questions
            ]
            print_table(("ID", "QUESTION", "FOR"), rows)
        else:
            print("no question waits")
        return 0
    if not options.answer:
        raise UsageError(f"answer yes or no: homebot answer {options.question} yes")
    request = {"question": options.question, "yes": options.answer == "yes"}
    door.ask(ANSWER_QUESTION, request)
    print(f"answered {options.answer}")
    return 0
