"""The thread and event loop that the brokers of tests live on, and the way there from any other loop or none."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Never, TypeVar, TypeVarTuple, Unpack, final

import anyio
from anyio.abc import TaskGroup, TaskStatus
from anyio.from_thread import BlockingPortal, start_blocking_portal

__all__ = ["BrokerThread", "broker_thread"]

_T = TypeVar("_T")
_Ts = TypeVarTuple("_Ts")


@contextmanager
def broker_thread() -> Iterator[BrokerThread]:
    """Start the thread; it ends with the block."""
    with start_blocking_portal("asyncio") as portal:
        thread = BrokerThread(portal)
        served, _ = portal.start_task(thread.serve)
        try:
            yield thread
        finally:
            portal.call(thread.close)
            served.result()


@final
class BrokerThread:
    """Runs coroutines on the thread's loop. What they raise reaches the caller and harms nobody else.

    Args:
        portal: The way in for callers that may block.
    """

    def __init__(self, portal: BlockingPortal) -> None:
        self._portal = portal
        self._tasks: TaskGroup | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def serve(self, *, task_status: TaskStatus[None]) -> None:
        """Run what :meth:`run` brings, until :meth:`close`; once, on the thread's loop."""
        self._loop = asyncio.get_running_loop()
        async with anyio.create_task_group() as self._tasks:
            task_status.started()
            await anyio.sleep_forever()

    async def close(self) -> None:
        """End :meth:`serve`."""
        if self._tasks is not None:
            self._tasks.cancel_scope.cancel()

    def call(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, without an event loop."""

        async def work() -> Callable[[], _T]:
            return await _outcome(function, *args)

        return self._portal.call(work)()

    async def run(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, on any asyncio loop; takes no lock, so it blocks nobody.

        Raises:
            RuntimeError: The thread has ended.
        """
        loop, tasks, home = self._loop, self._tasks, asyncio.get_running_loop()
        if loop is None or tasks is None:
            raise RuntimeError("the thread of the brokers does not run")
        answer: asyncio.Future[Callable[[], _T]] = home.create_future()
        scope = anyio.CancelScope()

        async def work() -> None:
            with scope:
                outcome = await _outcome(function, *args)
                if not home.is_closed():
                    home.call_soon_threadsafe(_answer, answer, outcome)

        loop.call_soon_threadsafe(tasks.start_soon, work)
        try:
            return (await answer)()
        except asyncio.CancelledError:
            loop.call_soon_threadsafe(scope.cancel)
            raise


async def _outcome(function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> Callable[[], _T]:
    try:
        value = await function(*args)
    except asyncio.CancelledError:
        raise
    except BaseException as error:  # noqa: BLE001 - also pytest.fail() in a test's predicate is the caller's
        return _raiser(error)
    return lambda: value


def _raiser(error: BaseException) -> Callable[[], Never]:
    def again() -> Never:
        raise error

    return again


def _answer(answer: asyncio.Future[_T], value: _T) -> None:
    if not answer.done():
        answer.set_result(value)
