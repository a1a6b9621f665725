"""An asynchronous context that stays open while its loop stands still, as it does between the steps of a test."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import AbstractAsyncContextManager, contextmanager
from typing import Any, TypeVar

__all__ = ["hold_open"]

ValueT = TypeVar("ValueT")


@contextmanager
def hold_open(loop: asyncio.AbstractEventLoop, context: AbstractAsyncContextManager[ValueT]) -> Iterator[ValueT]:
    """Enter *context* on *loop*, and leave it at the end of the block.

    It is entered and left in one task, as cancel scopes demand; the block's own errors do not reach it. When it ends by
    itself, because something in it broke, its error is raised at the end of the block.

    Args:
        loop: It does not run when the block begins, nor when it ends; in between anybody may run it.
        context: What to hold.
    """
    value: asyncio.Future[ValueT] = loop.create_future()
    leave = asyncio.Event()

    async def hold() -> None:
        async with context as entered:
            value.set_result(entered)
            await leave.wait()

    # A task without a group: none can be open around it while the loop stands still. The end of the block awaits it.
    holder = loop.create_task(hold(), name="held by a fixture")
    either: set[asyncio.Future[Any]] = {holder, value}
    loop.run_until_complete(asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED))
    if not value.done():
        value.cancel()
        holder.result()
    try:
        yield value.result()
    finally:
        leave.set()
        loop.run_until_complete(holder)
