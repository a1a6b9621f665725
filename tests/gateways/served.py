"""Simulated devices that are servers, and serve for as long as a test needs them."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Protocol

import anyio
from anyio.abc import TaskStatus

__all__ = ["served"]


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
