"""Simulated devices that are servers, and serve for as long as a test needs them."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Protocol

import anyio
from anyio.abc import TaskGroup, TaskStatus

from homebot.testing.gateway_contract import Lamp


class Server(Protocol):
    """What can serve."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None: ...


@asynccontextmanager
async def served(*servers: Server) -> AsyncIterator[None]:
    """Serve inside the block."""
    async with anyio.create_task_group() as tasks:
        for one in servers:
            await tasks.start(one.serve)
        yield
        tasks.cancel_scope.cancel()


class ServedLamp(Lamp):
    """A lamp behind a simulated server; its link is lost when that stops."""

    server: Server
    device: Server
    tasks: TaskGroup

    async def announce(self) -> None:
        await self.tasks.start(self.device.serve)

    async def flood(self, send: Callable[[int], None]) -> None:
        """Send 2,000 messages of a stranger by their numbers, so that the gateway gets its turn now and then."""
        for number in range(2000):
            send(number)
            if number % 50 == 49:
                await anyio.sleep(0.02)

    async def _serve(self, *, task_status: TaskStatus[None]) -> None:
        with anyio.CancelScope() as self._serving:
            await self.server.serve(task_status=task_status)

    async def lose_link(self) -> None:
        self._serving.cancel()
        await anyio.sleep(0.05)

    async def mend_link(self) -> None:
        await self.tasks.start(self._serve)


@asynccontextmanager
async def with_server(make: Callable[[TaskGroup], ServedLamp]) -> AsyncIterator[Lamp]:
    """Serve the server of the lamp inside the block."""
    async with anyio.create_task_group() as tasks:
        lamp = make(tasks)
        await lamp.mend_link()
        yield lamp
        tasks.cancel_scope.cancel()
