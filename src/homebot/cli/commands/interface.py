"""``homebot interface show``."""

import argparse
from typing import Final

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import definition_lines, typedefs
from homebot.errors import PeerError
from homebot.support.names import CLOSE, did_you_mean

_PARTS: Final = {
    "msg": ("message",),
    "srv": ("service_request", "service_response"),
    "action": ("action_goal", "action_result", "action_feedback"),
}
_EXAMPLES: Final = """\
  homebot interface show std_srvs/srv/SetBool
  homebot interface show geometry_msgs/msg/PoseStamped
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    command = add_verb(add_verbs(parser, _EXAMPLES), "show", "print the fields of a type")
    command.add_argument("type", metavar="TYPE", help="type of a message, service or action: PACKAGE/msg/NAME")
    set_door_command(command, _show, _EXAMPLES)


def _show(door: DoorClient, options: argparse.Namespace) -> int:
    kind = options.type.split("/")[1:-1]
    try:
        parts = [
            typedefs(door, f"/rosapi/{part}_details", options.type)
            for part in _PARTS.get(kind[0] if kind else "msg", _PARTS["msg"])
        ]
    except PeerError as exc:
        known = door.call("/rosapi/interfaces")["interfaces"]
        assert isinstance(known, list)  # noqa: S101 - for the type checker
        hint = did_you_mean(options.type, known, "`homebot service call /rosapi/interfaces` lists all", CLOSE)
        raise PeerError(f"there is no type {options.type!r}; {hint}") from exc
    print("\n---\n".join("\n".join(definition_lines(part)) for part in parts))
    return 0
