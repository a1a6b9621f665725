"""A peer's loop beside the measurement."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager

__all__ = ["in_background"]


@asynccontextmanager
async def in_background(work: Coroutine[None, None, None]) -> AsyncIterator[None]:
    """Run *work* inside the block; leaving cancels it."""
    task = asyncio.create_task(work)
    try:
        yield
    finally:
        while not task.done():  # asyncio.wait_for, which aiomqtt uses, swallows a cancellation now and then
            task.cancel()
            await asyncio.wait((task,), timeout=0.1)
    if not task.cancelled():
        task.result()
