"""Work beside a test, which leaves the test's own errors as they are."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager

import anyio

__all__ = ["in_background"]


@asynccontextmanager
async def in_background(*works: Callable[[], Coroutine[object, object, None]]) -> AsyncIterator[None]:
    """Run *works* during the block and end them with it.

    An error of the block passes as it is, not in a group: a failed assertion is what a test is about. Errors of *works*
    come in a group, and end the block.
    """
    failure: Exception | None = None
    async with anyio.create_task_group() as tasks:
        for work in works:
            tasks.start_soon(work)
        try:
            yield
        except Exception as error:  # noqa: BLE001 - whatever it is, it is raised again below
            failure = error
        tasks.cancel_scope.cancel()
    if failure is not None:
        raise failure
