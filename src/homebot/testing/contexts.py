"""Contexts around a test: concurrent tasks, open resources of fixtures, and its log."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from datetime import UTC, datetime
from typing import Any, TypeVar

import anyio
import structlog
from structlog.typing import EventDict, WrappedLogger

from homebot.clock import Clock
from homebot.support.logger import ConsoleRenderer, with_local_time


@asynccontextmanager
async def in_background(*works: Callable[[], Coroutine[object, object, None]]) -> AsyncIterator[None]:
    """Run *works* during the block, and end them with it.

    Errors of the block are raised unchanged, as failed assertions are the subject of a test. Errors of *works* are
    raised in a group, and end the block.
    """
    failure: Exception | None = None
    async with anyio.create_task_group() as tasks:
        for work in works:
            tasks.start_soon(work)
        try:
            yield
        except Exception as error:  # noqa: BLE001 - raised again below
            failure = error
        tasks.cancel_scope.cancel()
    if failure is not None:
        raise failure


ValueT = TypeVar("ValueT")


@contextmanager
def hold_open(loop: asyncio.AbstractEventLoop, context: AbstractAsyncContextManager[ValueT]) -> Iterator[ValueT]:
    """Enter *context* on *loop*, and leave it at the end of the block.

    It is entered and left in one task, as cancel scopes require; errors of the block do not reach it. If it fails in
    the meantime, its error is raised at the end of the block.

    Args:
        loop: Must not be running at the beginning and end of the block; in between it may run elsewhere.
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


@contextmanager
def plain_logs(clock: Clock | None = None) -> Iterator[None]:
    """Write the log during the block as ``homebot run`` does, unless the program has set up structlog itself.

    structlog's default writes the computer's time, includes debugging, and with ``rich`` installed draws tracebacks
    with the values of all variables: hundreds of lines for a crashed app, secrets included.

    Args:
        clock: The clock of the house, whose time in UTC the lines have; by default the computer's time.
    """
    if structlog.is_configured():
        yield
        return
    render = ConsoleRenderer(colours=False)

    def write(logger: WrappedLogger, method: str, event: EventDict) -> str:
        if event["level"] == "debug":
            raise structlog.DropEvent
        if clock is not None:
            event["timestamp"] = datetime.fromtimestamp(clock.now(), UTC).isoformat()
        return render(logger, method, event)

    before = structlog.processors.add_log_level, with_local_time, structlog.processors.format_exc_info
    structlog.configure(processors=[*before, write])
    try:
        yield
    finally:
        if structlog.get_config()["processors"][-1] is write:  # otherwise the program has set it up in the meantime
            structlog.reset_defaults()
