"""Fixtures that hold a node or a task group."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import TypeVar

EnteredT = TypeVar("EnteredT")


@asynccontextmanager
async def in_one_task(context: AbstractAsyncContextManager[EnteredT]) -> AsyncIterator[EnteredT]:
    """Enter and leave *context* in one task; pytest-asyncio sets a fixture up in one and tears it down in another."""
    entered: asyncio.Future[EnteredT] = asyncio.get_running_loop().create_future()
    is_over = asyncio.Event()

    async def hold() -> None:
        async with context as value:
            entered.set_result(value)
            await is_over.wait()

    holder = asyncio.create_task(hold())
    await asyncio.wait((holder, entered), return_when=asyncio.FIRST_COMPLETED)
    try:
        if entered.done():  # else the holder raises what went wrong
            yield entered.result()
    finally:
        is_over.set()
        await holder
