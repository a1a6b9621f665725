"""Prints what a family's house says and does to its very end.

Run as a program by a test, as ``a_shutdown.py SEED BALLAST``.
"""

import asyncio
import sys
import tomllib
from collections.abc import MutableMapping
from pathlib import Path
from random import Random
from typing import Any

import anyio
import structlog
from anyio.abc import TaskGroup

from homebot.errors import ClosedError
from homebot.house.description import parse_world
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.testing import VirtualHouse, VirtualTimeLoop, virtual_house_of

FAMILY = tomllib.loads((Path(__file__).parents[3] / "examples" / "houses" / "family.toml").read_text("utf-8"))


class OnPurposeError(Exception):
    """Ends the house in the middle."""


async def watch(house: VirtualHouse, lines: list[str]) -> None:
    """Write down every message and every change of the graph until cancelled: longer than the house lives."""
    options = MqttOptions.from_url(house.broker.url, client_id="watcher", keep_alive=3_600)
    random = Random(0)  # noqa: S311 - a simulation has no secrets
    connection = MqttConnection(options, house.broker.make_client, status_topic=None, clock=house.clock, random=random)

    async def read_graph() -> None:
        with house.runtime.graph.watch() as changes:
            async for change in changes:
                entity = change.entity
                lines.append(f"graph {change.change} {entity.kind.value} {entity.name} of {entity.node}")

    async with connection, anyio.create_task_group() as tasks:
        tasks.start_soon(read_graph)
        await connection.subscribe(MqttSubscription("#"))
        while True:
            try:
                messages = await connection.receive()
            except ClosedError:
                return
            lines += [f"mqtt {message.topic} {message.payload!r}" for message in messages]


async def live(seed: int, how: str, lines: list[str], outside: TaskGroup) -> None:
    world = parse_world(FAMILY, "family.toml", seed=seed)
    async with virtual_house_of("light_service", world=world, seed=seed) as house:
        outside.start_soon(watch, house, lines)
        await house.run_for("10m")
        for number in range(20):
            await house.says(f"home425/lights/l{number}/out", "on")
        lines.append(f"-- {how}")
        if how == "raise":
            raise OnPurposeError


async def end(seed: int, how: str, lines: list[str]) -> None:
    """Leave a house, or have an error end it."""
    async with anyio.create_task_group() as outside:
        try:
            await live(seed, how, lines, outside)
        except* OnPurposeError:
            lines.append("-- raised")
        outside.cancel_scope.cancel()


if __name__ == "__main__":
    said: list[str] = []
    # Where tasks lie in memory decides in what order a set of them is gone through.
    ballast = [bytes(size) for size in range(16, 512, 16) for _ in range(int(sys.argv[2]))]

    def note(_logger: object, method: str, event: MutableMapping[str, Any]) -> str:
        said.append(f"log {method} " + " ".join(f"{key}={event[key]!r}" for key in sorted(event) if key != "exc_info"))
        raise structlog.DropEvent

    structlog.configure(processors=[note])
    for each in ("leave", "raise"):
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            runner.run(end(int(sys.argv[1]), each, said))
    sys.stdout.write("\n".join(said) + "\n")
