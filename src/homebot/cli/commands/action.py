"""``homebot action``: ``list``, ``info`` and ``send_goal``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from textwrap import indent
from typing import TYPE_CHECKING, Final

from homebot.cli.arguments import add_verb, add_verbs, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.flow import message, type_or_message
from homebot.cli.graph_queries import entities, is_hidden, not_found
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError

if TYPE_CHECKING:
    from homebot.bridges.rosapi.endpoints import EndpointDetails

__all__ = ["add_arguments"]

_ENDS: Final = {"action client": "Action clients", "action server": "Action servers"}
_STATES: Final = ("UNKNOWN", "ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED")
_SUCCEEDED: Final = 4

_EXAMPLES = """\
  homebot action list -t
  homebot action info /navigate_to_pose
"""
_GOAL_EXAMPLES = """\
  homebot action send_goal /fibonacci '{order: 5}'
  homebot action send_goal --feedback /fibonacci example_interfaces/action/Fibonacci '{order: 5}'
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the commands below ``homebot action``."""
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list every action")
    command.add_argument("-t", "--show-types", action="store_true", help="show each action's type")
    set_client_command(command, _list, "  homebot action list\n  homebot action list -t\n")
    command = add_verb(verbs, "info", "show the servers and clients of an action")
    command.add_argument("action", metavar="ACTION", help="name of the action")
    command.add_argument("-t", "--show-types", action="store_true", help="show the type too")
    set_client_command(command, _info, "  homebot action info /fibonacci\n")
    command = add_verb(verbs, "send_goal", "send a goal, and wait for its result; Ctrl-C cancels it")
    command.add_argument("action", metavar="ACTION", help="name of the action")
    command.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="type to expect; any if left out"
    )
    command.add_argument(
        "goal", metavar="GOAL", nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )
    command.add_argument("-f", "--feedback", action="store_true", help="print the feedback too")
    set_client_command(command, _send_goal, _GOAL_EXAMPLES)


def _list(options: argparse.Namespace) -> int:
    """Print every action, one a line."""

    def run(door: DoorClient) -> int:
        for name, ros_type in sorted({(one.name, one.type) for one in _ends(door) if not is_hidden(one)}):
            print(f"{name} [{ros_type}]" if options.show_types else name)
        return 0

    return with_client(options, run)


def _info(options: argparse.Namespace) -> int:
    """Print the nodes at both ends of an action."""

    def run(door: DoorClient) -> int:
        ends = _ends_of(door, options.action)
        print(f"Action: {ends[0].name}" + (f" [{ends[0].type}]" if options.show_types else ""))
        for kind, title in _ENDS.items():
            nodes = [one.node for one in ends if one.kind == kind]
            print(f"{title}: {len(nodes)}")
            for node in nodes:
                print(f"    {node}")
        return 0

    return with_client(options, run)


def _send_goal(options: argparse.Namespace) -> int:
    """Send a goal and print its result; return 1 unless it succeeded."""
    expected, goal = options.type, options.goal
    if isinstance(expected, dict):  # the type was left out
        expected, goal = "", expected

    def run(door: DoorClient) -> int:
        end = _ends_of(door, options.action)[0]
        if expected and expected.replace("/action/", "/") != end.type.replace("/action/", "/"):
            raise PeerError(f"action {end.name} is a {end.type}, not a {expected}")
        _show("Sending goal", goal)
        for frame in door.perform(end.name, end.type, goal):
            values = frame.get("values")
            if frame["op"] == "action_result":
                return _finish(end.name, frame)
            if options.feedback and isinstance(values, dict):
                _show("Feedback", values)
        return 1

    return with_client(options, run)


def _finish(action: str, frame: Mapping[str, object]) -> int:
    """Print the result in *frame* and return the exit code."""
    values, status = frame.get("values"), frame.get("status")
    if not isinstance(values, dict):
        raise PeerError(f"action {action} failed: {values}")
    _show("Result", values)
    state = _STATES[status] if isinstance(status, int) and 0 <= status < len(_STATES) else str(status)
    print(f"Goal finished with status: {state}", file=sys.stdout if status == _SUCCEEDED else sys.stderr)
    return 0 if status == _SUCCEEDED else 1


def _show(title: str, values: Mapping[str, object]) -> None:
    print(f"{title}:\n{indent(to_yaml(dict(values)), '    ')}", flush=True)


def _ends(door: DoorClient) -> list[EndpointDetails]:
    return [one for one in entities(door) if one.kind in _ENDS]


def _ends_of(door: DoorClient, action: str) -> list[EndpointDetails]:
    """Return the ends of *action*, at least one.

    Raises:
        PeerError: There is no such action.
    """
    name = action if action.startswith("/") else f"/{action}"
    ends = _ends(door)
    found = [one for one in ends if one.name == name]
    if not found:
        raise not_found("action", name, {one.name for one in ends})
    return found
