"""``homebot node list`` and ``homebot node info``."""

from __future__ import annotations

import argparse

from homebot.cli.directory import entities
from homebot.cli.door_client import DoorClient
from homebot.cli.similar import not_found
from homebot.cli.with_client import with_client
from homebot.errors import PeerError

__all__ = ["info", "list_nodes"]

_SECTIONS = {
    "subscription": "Subscribers",
    "publisher": "Publishers",
    "service": "Service Servers",
    "client": "Service Clients",
}


def list_nodes(options: argparse.Namespace) -> int:
    """Print every node, one a line."""

    async def run(door: DoorClient) -> int:
        for one in await entities(door, kind="node"):
            if options.all or not one.is_hidden:
                print(one.name)
        return 0

    return with_client(options, run)


def info(options: argparse.Namespace) -> int:
    """Print what a node reads, publishes, serves and calls."""

    async def run(door: DoorClient) -> int:
        name = options.node if options.node.startswith("/") else f"/{options.node}"
        ends = await entities(door, node=name)
        if not ends:
            known = [one.name for one in await entities(door, kind="node")]
            raise PeerError(not_found("node", name, known))
        print(name)
        for kind, title in _SECTIONS.items():
            print(f"  {title}:")
            for line in sorted({f"    {one.name}: {one.type}" for one in ends if one.kind == kind}):
                print(line)
        return 0

    return with_client(options, run)
