"""The thread and event loop that the brokers of tests live on, and the way there from any other loop or none."""

from __future__ import annotations

import asyncio
import concurrent.futures
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from contextvars import Context, copy_context
from typing import Any, Final, TypeVar, TypeVarTuple, Unpack, final

from anyio.from_thread import start_blocking_portal

_T = TypeVar("_T")
_Ts = TypeVarTuple("_Ts")

_ENDED: Final = "the broker thread has ended"


@contextmanager
def broker_thread() -> Iterator[BrokerThread]:
    """Start the thread; it ends with the block."""
    thread = BrokerThread()
    with start_blocking_portal("asyncio") as portal:
        portal.call(thread.begin)
        try:
            yield thread
        finally:
            thread.end()


@final
class BrokerThread:
    """Runs coroutines on the thread's loop. Their exceptions reach only the caller."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ident = 0
        self._context = Context()  # tells anyio the kind of loop, also where trio calls
        self._jobs: set[concurrent.futures.Future[Any]] = set()

    def begin(self) -> None:
        """Take the calls of :meth:`call` and :meth:`run` from now on; called on the thread's loop."""
        self._loop, self._context, self._ident = asyncio.get_running_loop(), copy_context(), threading.get_ident()

    def end(self) -> None:
        """Take no more of them, and cancel the others."""
        self._loop = None
        for job in tuple(self._jobs):
            job.cancel()

    def call(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, without an event loop.

        Raises:
            RuntimeError: The thread has ended, or is the caller's own.
        """
        if threading.get_ident() == self._ident:
            raise RuntimeError("this would block the broker thread, in which it runs")
        job = self._start(function, *args)
        try:
            return job.result()
        except concurrent.futures.CancelledError:
            raise RuntimeError(_ENDED) from None
        except BaseException:  # Ctrl-C
            job.cancel()
            raise

    async def run(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> _T:
        """Run ``function(*args)`` and wait for it, on any asyncio loop.

        Raises:
            RuntimeError: The thread has ended.
        """
        try:
            return await asyncio.wrap_future(self._start(function, *args))
        except asyncio.CancelledError:
            if self._loop is None:
                raise RuntimeError(_ENDED) from None
            raise

    def _start(self, function: Callable[[Unpack[_Ts]], Awaitable[_T]], *args: *_Ts) -> concurrent.futures.Future[_T]:
        if self._loop is None:
            raise RuntimeError("the broker thread is not running")

        async def work() -> _T:
            return await function(*args)

        job = self._context.copy().run(asyncio.run_coroutine_threadsafe, work(), self._loop)
        self._jobs.add(job)
        job.add_done_callback(self._jobs.discard)
        return job
