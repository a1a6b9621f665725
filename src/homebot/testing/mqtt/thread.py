"""The thread and event loop that the brokers of tests live on, and the way there from any other loop or none."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from contextvars import Context, copy_context
from typing import Generic, Never, TypeVar, TypeVarTuple, Unpack, final

import anyio
from anyio.abc import TaskGroup, TaskStatus
from anyio.from_thread import start_blocking_portal

__all__ = ["BrokerThread", "broker_thread"]

_T = TypeVar("_T")
_Ts = TypeVarTuple("_Ts")


@contextmanager
def broker_thread() -> Iterator[BrokerThread]:
    """Start the thread; it ends with the block."""
    thread = BrokerThread()
    with start_blocking_portal("asyncio") as portal:
        served, _ = portal.start_task(thread.serve)
        try:
            yield thread
        finally:
            portal.call(thread.close)
            served.result()


@final
class BrokerThread:
    """Runs coroutines on the thread's loop. Their exceptions reach only the caller."""

    def __init__(self) -> None:
        self._tasks: TaskGroup | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ident = 0
        self._context = Context()  # tells anyio the kind of loop, also where trio is installed

    async def serve(self, *, task_status: TaskStatus[None]) -> None:
        """Run the work of :meth:`call` and :meth:`run` until :meth:`close`; once, on the thread's loop."""
        self._ident = threading.get_ident()
        try:
            async with anyio.create_task_group() as self._tasks:
                self._loop, self._context = asyncio.get_running_loop(), copy_context()
                task_status.started()
                await anyio.sleep_forever()
        finally:
            self._loop = self._tasks = None

    async def close(self) -> None:
        """End :meth:`serve`."""
        if self._tasks is not None:
            self._tasks.cancel_scope.cancel()

    def call(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, without an event loop.

        Raises:
            RuntimeError: The thread has ended, or is the caller's own.
        """
        if threading.get_ident() == self._ident:
            raise RuntimeError("this would block the broker thread, in which it runs")
        answer: Future[Callable[[], _T]] = Future()
        job = _Job(lambda: function(*args), answer.set_result)
        loop = self._start(job)
        try:
            outcome = answer.result()
        except BaseException:  # Ctrl-C
            loop.call_soon_threadsafe(job.cancel)
            raise
        return outcome()

    async def run(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, on any asyncio loop; takes no lock, so it blocks no thread.

        Raises:
            RuntimeError: The thread has ended.
        """
        home = asyncio.get_running_loop()
        answer: asyncio.Future[Callable[[], _T]] = home.create_future()

        def ended(outcome: Callable[[], _T]) -> None:
            if not home.is_closed():
                home.call_soon_threadsafe(_answer, answer, outcome)

        job = _Job(lambda: function(*args), ended)
        loop = self._start(job)
        try:
            return (await answer)()
        except asyncio.CancelledError:
            loop.call_soon_threadsafe(job.cancel)
            raise

    def _start(self, job: _Job[_T]) -> asyncio.AbstractEventLoop:
        loop = self._loop
        if loop is None:
            raise RuntimeError("the broker thread is not running")
        loop.call_soon_threadsafe(self._spawn, job, context=self._context)
        return loop

    def _spawn(self, job: _Job[_T]) -> None:
        if self._tasks is None:
            job.abandon()
        else:
            self._tasks.start_soon(job.work)


@final
class _Job(Generic[_T]):
    """One call; all its methods are for the thread's loop.

    Args:
        ended: Called once with the result: a function that returns or raises it.
    """

    def __init__(self, function: Callable[[], Awaitable[_T]], ended: Callable[[Callable[[], _T]], object]) -> None:
        self._function = function
        self._ended = ended
        self._scope: anyio.CancelScope | None = None
        self._cancelled = False

    async def work(self) -> None:
        outcome: Callable[[], _T] = _raiser(RuntimeError("the broker thread has ended"))
        try:
            with anyio.CancelScope() as self._scope:
                if self._cancelled:
                    self._scope.cancel()
                outcome = await _outcome(self._function)
        finally:
            self._ended(outcome)

    def abandon(self) -> None:
        self._ended(_raiser(RuntimeError("the broker thread has ended")))

    def cancel(self) -> None:
        self._cancelled = True
        if self._scope is not None:
            self._scope.cancel()


async def _outcome(function: Callable[[], Awaitable[_T]]) -> Callable[[], _T]:
    try:
        value = await function()
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
