"""Makes the first call of each offered service and action of a house, and prints the longest turn of the loop in each.

A turn is given in seconds of the processor, with the name.
"""

import asyncio
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

import anyio

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.protocol import CallService
from homebot.bridges.rosbridge.services import call_service
from homebot.bridges.time_slices import ServerTurns
from homebot.config import parse_config
from homebot.devices.client_rights import ALL_RIGHTS
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import HomebotError
from homebot.graph import Node
from homebot.graph.actions import ActionClient
from homebot.house import thesis_world
from homebot.messages.definition import zero_message
from homebot.messages.message import Message
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.support.production_loop import ProductionLoop

_LONGEST = 5.0
"""Seconds of a call; what a goal does afterwards is its own affair."""


class Turns:
    """The longest turn of a loop since it was last asked for."""

    def __init__(self, select: Callable[[float | None], list[object]]) -> None:
        self._select, self._began, self._longest = select, time.thread_time(), 0.0

    def select(self, timeout: float | None = None) -> list[object]:
        self._longest = max(self._longest, time.thread_time() - self._began)
        try:
            return self._select(timeout)
        finally:
            self._began = time.thread_time()

    def longest(self) -> float:
        longest, self._longest = self._longest, 0.0
        return longest


async def main(order: int) -> None:
    loop = asyncio.get_running_loop()
    selector = loop._selector  # type: ignore[attr-defined]
    turns = Turns(selector.select)
    selector.select = turns.select
    with TemporaryDirectory() as folder:
        config = parse_config({"gateways": {"mqtt": {}}}, "")
        index = Path(folder, "index.sqlite")
        async with (
            MemoryBroker() as broker,
            Runtime(
                config,
                house=thesis_world(),
                with_door=False,
                index_file=index,
                services=(HostedBroker.in_memory(broker),),
            ) as runtime,
            Node(runtime.graph, "caller") as node,
        ):
            await anyio.sleep(3.0)  # what runs all the time has begun
            for name in sorted(runtime.graph._offered)[::order]:
                turns.longest()
                with anyio.move_on_after(_LONGEST):
                    await call(node, name)
                await anyio.sleep(0.05)
                print(f"{turns.longest():.4f} {name}")


async def call(node: Node, name: str) -> None:
    if any(action.name == name for action in node.graph.actions()):
        await node.graph.begin(name)
        action_type = node.graph.get_action_type(name)
        assert action_type is not None
        with suppress(HomebotError):
            goal = await ActionClient(node, action_type, name).send_goal(
                zero_message(cast("type[Message]", action_type.Goal))
            )
            goal.request_cancel()
        return
    access = ClientAccess("test", ALL_RIGHTS, RobotOwners({}))
    await call_service(node, CallService(op="call_service", service=name), ServerTurns(), access, lambda _: None)


with asyncio.Runner(loop_factory=ProductionLoop) as runner:
    runner.run(main(int(sys.argv[1])))
