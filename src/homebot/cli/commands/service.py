"""``homebot service``: ``list``, ``type``, ``find`` and ``call``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from typing import cast

from homebot.cli.arguments import add_verb, add_verbs, positive, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.flow import message, type_or_message
from homebot.cli.graph_queries import (
    MessageTypeRecord,
    entities,
    is_hidden,
    not_found,
    print_of_type,
    response_schema,
)
from homebot.cli.table import printable
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError, UsageError

__all__ = ["add_arguments"]

_REQUEST = "/rosapi/service_request_details"


_EXAMPLES = """\
  homebot service list -t
  homebot service call /rosapi/get_time
"""
_CALL_EXAMPLES = """\
  homebot service call /rosapi/get_time
  homebot service call /getIndexData '{service_type: lights}'
  homebot service call /rosapi/topic_type rosapi_msgs/srv/TopicType '{"topic": "/rosout"}'
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the commands below ``homebot service``."""
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list every service")
    command.add_argument("-t", "--show-types", action="store_true", help="show each service's type")
    command.add_argument("-a", "--all", action="store_true", help="show hidden services too")
    set_client_command(command, _list, "  homebot service list\n  homebot service list -t\n")
    command = add_verb(verbs, "type", "print the type of a service")
    command.add_argument("service", metavar="SERVICE", help="name of the service")
    set_client_command(command, _print_type, "  homebot service type /rosapi/get_time\n")
    command = add_verb(verbs, "find", "list the services of a type")
    command.add_argument("type", metavar="TYPE", help="type of the services")
    command.add_argument("-a", "--all", action="store_true", help="show hidden services too")
    set_client_command(command, _find, "  homebot service find rosapi_msgs/srv/GetTime\n")
    command = add_verb(verbs, "call", "call a service and print its response")
    command.add_argument("service", metavar="SERVICE", help="name of the service")
    command.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="type to expect; any if left out"
    )
    command.add_argument(
        "request", metavar="REQUEST", nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )
    command.add_argument("--timeout", metavar="S", type=positive, default=5.0, help="seconds to wait (default: 5)")
    command.add_argument("--json", action="store_true", help="print the response as one line of JSON")
    set_client_command(command, _call, _CALL_EXAMPLES)


def _list(options: argparse.Namespace) -> int:
    """Print every service, one a line."""

    def run(door: DoorClient) -> int:
        for one in entities(door, kind="service"):
            if options.all or not is_hidden(one):
                print(f"{one.name} [{one.type}]" if options.show_types else one.name)
        return 0

    return with_client(options, run)


def _print_type(options: argparse.Namespace) -> int:
    """Print the type of a service."""

    def run(door: DoorClient) -> int:
        print(_type(door, options.service, ""))
        return 0

    return with_client(options, run)


def _find(options: argparse.Namespace) -> int:
    """Print the services of a type, one a line; return 1 if there are none."""
    return with_client(options, lambda door: print_of_type(door, "service", options.type, show_hidden=options.all))


def _call(options: argparse.Namespace) -> int:
    """Call a service and print its response; return 1 where the response says that it did not work."""
    expected, request = options.type, options.request
    if isinstance(expected, dict):  # the type was left out
        expected, request = "", expected

    def run(door: DoorClient) -> int:
        ros_type = _type(door, options.service, expected)
        response = door.call(options.service, request, options.timeout)
        if options.json:
            print(json.dumps(response))
        else:
            print(to_yaml(response_schema(door, ros_type).readable(response)), end="")
        return _exit_code(options.service, response)

    return with_client(options, run)


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


def _type(door: DoorClient, service: str, expected: str) -> str:
    """Return the type of *service*, which should be the *expected* one, if any."""
    name = service if service.startswith("/") else f"/{service}"
    known = {one.name: one.type for one in entities(door, kind="service")}
    if name not in known:
        raise not_found("service", name, known)
    if expected and expected.replace("/srv/", "/") != known[name].replace("/srv/", "/"):
        if "/" not in expected:
            (request,) = cast("list[MessageTypeRecord]", door.call(_REQUEST, {"type": known[name]})["typedefs"])[:1]
            field = next(iter(request["fieldnames"]), "field")
            raise UsageError(f"{expected!r} was taken as a type; write the request as {{{field}: {expected}}}")
        raise PeerError(f"service {name} is a {known[name]}, not a {expected}")
    return known[name]
