"""``homebot service``: ``list``, ``type``, ``find``, ``call`` and ``install``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from typing import cast

from homebot.cli.arguments import add_verb, add_verbs, seconds, set_client_command
from homebot.cli.door_client import DoorClient, door_command
from homebot.cli.entity_verbs import add_entity_verbs, add_value_arguments, check_type, type_of
from homebot.cli.graph_queries import MessageTypeRecord, response_schema
from homebot.cli.service_unit import add_install_arguments
from homebot.cli.yaml import to_yaml
from homebot.errors import UsageError
from homebot.support.printable import printable

__all__ = ["add_arguments"]

_REQUEST = "/rosapi/service_request_details"


_EXAMPLES = """\
  homebot service list -t
  homebot service call /rosapi/get_time
  homebot service install --user    run homebot from the start of the computer
"""
_CALL_EXAMPLES = """\
  homebot service call /rosapi/get_time
  homebot service call /getIndexData '{service_type: lights}'
  homebot service call /rosapi/topic_type rosapi_msgs/srv/TopicType '{"topic": "/rosout"}'
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the commands below ``homebot service``."""
    verbs = add_verbs(parser, _EXAMPLES)
    add_entity_verbs(verbs, "service", "/rosapi/get_time", "rosapi_msgs/srv/GetTime")
    command = add_verb(verbs, "call", "call a service and print its response")
    add_value_arguments(command, "service", "request")
    command.add_argument("--timeout", metavar="S", type=seconds, default=5.0, help="seconds to wait (default: 5)")
    command.add_argument("--json", action="store_true", help="print the response as one line of JSON")
    set_client_command(command, _call, _CALL_EXAMPLES, acts=True)
    add_install_arguments(add_verb(verbs, "install", "install a systemd unit that runs homebot"))


@door_command
def _call(door: DoorClient, options: argparse.Namespace) -> int:
    """Call a service and print its response; return 1 where the response says that it did not work."""
    expected, request = options.type, options.request
    if isinstance(expected, dict):  # the type was left out
        expected, request = "", expected
    ros_type = type_of(door, "service", options.service)
    if expected and "/" not in expected and not request:
        (typedef,) = cast("list[MessageTypeRecord]", door.call(_REQUEST, {"type": ros_type})["typedefs"])[:1]
        field = next(iter(typedef["fieldnames"]), "field")
        raise UsageError(f"{expected!r} was taken as a type; write the request as {{{field}: {expected}}}")
    check_type("service", options.service, ros_type, expected)
    response = door.call(options.service, request, options.timeout)
    if options.json:
        print(json.dumps(response))
    else:
        print(to_yaml(response_schema(door, ros_type).readable(response)), end="")
    return _exit_code(options.service, response)


def _exit_code(service: str, response: Mapping[str, object]) -> int:
    """Print the failure that *response* reports, if any, and return the exit code; fields as in ROS's services."""
    for name in ("success", "successful"):
        if response.get(name) is False:
            reason = next(
                (str(response[key]) for key in ("message", "reason") if response.get(key)), "it gave no reason"
            )
            print(f"homebot: {service} reported a failure: {printable(reason)}", file=sys.stderr)
            return 1
    return 0
