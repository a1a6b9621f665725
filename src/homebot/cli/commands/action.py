"""``homebot action``: ``list`` and ``send_goal``."""

import argparse
import sys
from collections.abc import Iterable, Mapping
from textwrap import indent
from typing import Final

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, ReceivedMessage, set_door_command
from homebot.cli.graph_queries import add_list_verb, add_value_arguments, check_type, type_of
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError
from homebot.names import absolute_name

_SUCCEEDED: Final = "SUCCEEDED"
_STATES: Final = ("UNKNOWN", "ACCEPTED", "EXECUTING", "CANCELING", _SUCCEEDED, "CANCELED", "ABORTED")
_CANCEL_WITHIN: Final = 5.0

_EXAMPLES = """\
  homebot action list -t
  homebot action send_goal /fibonacci '{order: 5}'
"""
_GOAL_EXAMPLES = """\
  homebot action send_goal /fibonacci '{order: 5}'
  homebot action send_goal --feedback /fibonacci example_interfaces/action/Fibonacci '{order: 5}'
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    add_list_verb(verbs, "action")
    command = add_verb(verbs, "send_goal", "send a goal, and wait for its result; Ctrl-C cancels it")
    add_value_arguments(command, "action", "goal")
    command.add_argument("-f", "--feedback", action="store_true", help="print the feedback too")
    set_door_command(command, _send_goal, _GOAL_EXAMPLES, acts=True)


def _send_goal(door: DoorClient, options: argparse.Namespace) -> int:
    """Send a goal and print its result; return 1 unless it succeeded."""
    name = absolute_name(options.action)
    ros_type = type_of(door, "action", name)
    if isinstance(options.type, dict):  # the type was omitted
        options.type, options.goal = "", options.type
    check_type("action", name, ros_type, options.type)
    _show("Sending goal", options.goal)
    goal = door.send_goal(name, ros_type, options.goal)
    try:
        state = _follow_goal(name, iter(door.next, None), options)
    except KeyboardInterrupt:
        print(f"Cancelling the goal; its end is awaited for {_CANCEL_WITHIN:g} s", file=sys.stderr)
        door.cancel_goal(name, goal)
        if not _follow_goal(name, door.until(_CANCEL_WITHIN), options):
            print(f"Goal still executing: {name} has not ended it yet", file=sys.stderr)
        raise
    return 0 if state == _SUCCEEDED else 1


def _follow_goal(action: str, received: Iterable[ReceivedMessage], options: argparse.Namespace) -> str:
    """Print the news *received* of a goal; return the state in which it ended, empty if it has not."""
    for _, frame, _ in received:
        values = frame.get("values")
        if not isinstance(values, dict):
            raise PeerError(f"action {action} failed: {values}")
        if frame["op"] == "action_result":
            _show("Result", values)
            state = _STATES[int(str(frame["status"]))]
            print(f"Goal finished with status: {state}", file=sys.stdout if state == _SUCCEEDED else sys.stderr)
            return state
        if options.feedback:
            _show("Feedback", values)
    return ""


def _show(title: str, values: Mapping[str, object]) -> None:
    print(f"{title}:\n{indent(to_yaml(dict(values)), '    ')}", flush=True)
