"""``homebot service list`` and ``homebot service call``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping

from homebot.cli.directory import entities
from homebot.cli.door_client import DoorClient
from homebot.cli.schema import response_schema
from homebot.cli.similar import not_found
from homebot.cli.table import printable
from homebot.cli.with_client import with_client
from homebot.cli.yaml import to_yaml
from homebot.errors import PeerError

__all__ = ["call", "list_services"]


def list_services(options: argparse.Namespace) -> int:
    """Print every service, one a line."""

    async def run(door: DoorClient) -> int:
        for one in await entities(door, kind="service"):
            if options.all or not one.is_hidden:
                print(f"{one.name} [{one.type}]" if options.show_types else one.name)
        return 0

    return with_client(options, run)


def call(options: argparse.Namespace) -> int:
    """Call a service and print its response; return 1 where the response says that it did not work."""
    expected, request = options.type, options.request
    if isinstance(expected, dict):  # the type was left out
        expected, request = "", expected

    async def run(door: DoorClient) -> int:
        ros_type = await _type(door, options.service, expected)
        response = await door.call(options.service, request, options.timeout)
        if options.json:
            print(json.dumps(response))
        else:
            print(to_yaml((await response_schema(door, ros_type)).readable(response)), end="")
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


async def _type(door: DoorClient, service: str, expected: str) -> str:
    """Return the type of *service*, which should be the *expected* one, if any."""
    name = service if service.startswith("/") else f"/{service}"
    known = {one.name: one.type for one in await entities(door, kind="service")}
    if name not in known:
        raise PeerError(not_found("service", name, known))
    if expected and expected.replace("/srv/", "/") != known[name].replace("/srv/", "/"):
        raise PeerError(f"service {name} is a {known[name]}, not a {expected}")
    return known[name]
