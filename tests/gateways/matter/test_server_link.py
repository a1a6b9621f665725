"""The connection to a Matter server: long lists of nodes."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Awaitable, Callable
from typing import NoReturn

import anyio
import anyio.lowlevel
from tests.patience import PATIENCE

from homebot.gateways.matter.server_link import MatterServerLink
from homebot.gateways.matter.server_messages import MatterEvent

GREETING = {"schema_version": 11, "min_supported_schema_version": 9, "sdk_version": "2025.7.0"}


class QueuedSocket:
    """A socket on which frames wait already."""

    def __init__(self, *frames: object) -> None:
        self.frames = deque(json.dumps(frame) for frame in frames)
        self.sent: list[str | bytes] = []

    async def send(self, message: str | bytes) -> None:
        self.sent.append(message)

    async def receive(self) -> str | bytes:
        return self.frames.popleft()

    async def receive_all(
        self, take: Callable[[bytes], Awaitable[None]], reject: Callable[[bytes, str], None]
    ) -> NoReturn:
        while self.frames:
            await take(self.frames.popleft().encode())
        await anyio.sleep_forever()
        raise AssertionError(reject)


async def test_other_tasks_run_while_a_list_of_many_megabytes_is_parsed() -> None:
    values = {f"1/{cluster}/{attribute}": "x" * 100 for cluster in range(50) for attribute in range(100)}
    nodes = [{"node_id": number, "available": True, "attributes": values} for number in range(1, 9)]
    socket = QueuedSocket(GREETING, {"message_id": "1", "result": nodes})
    turns, listed = 0, anyio.Event()

    async def take_turns() -> None:
        nonlocal turns
        while True:
            await anyio.lowlevel.checkpoint()
            turns += 1

    async def take_nodes(taken: object) -> None:
        assert taken == nodes
        listed.set()

    async def take_event(event: MatterEvent, payload: bytes) -> None:
        raise AssertionError(event, payload)

    def take_invalid(payload: bytes, reason: str) -> None:
        raise AssertionError(reason, payload)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(take_turns)
        tasks.start_soon(MatterServerLink(socket, take_nodes, take_event, take_invalid).run)
        with anyio.fail_after(PATIENCE):
            await listed.wait()
        tasks.cancel_scope.cancel()
    assert turns >= len(nodes)
