"""Results that come later, and the callbacks that a spinning thread runs."""

from __future__ import annotations

import asyncio
import queue
from collections.abc import Callable, Coroutine, Generator
from contextlib import suppress
from inspect import iscoroutine
from typing import Generic, TypeVar, cast

__all__ = ["CallbackQueue", "Future"]

T = TypeVar("T")


class Future(Generic[T]):
    """The result of a call, set by the thread that spins.

    ``await`` it in a coroutine callback; ``spin_until_future_complete`` elsewhere.
    """

    def __init__(self) -> None:
        self._done = False
        self._result: T | None = None
        self._exception: BaseException | None = None
        self._callbacks: list[Callable[[Future[T]], object]] = []

    def __await__(self) -> Generator[Future[T], None, T]:
        while not self._done:
            yield self
        return cast("T", self.result())

    def done(self) -> bool:
        """Return whether there is a result, an exception or neither any more."""
        return self._done

    def result(self) -> T | None:
        """Return the result; None before there is one.

        Raises:
            BaseException: The one that was set.
        """
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception that was set, or None."""
        return self._exception

    def set_result(self, result: T) -> None:
        """Set the result and call the callbacks."""
        self._result = result
        self._finish()

    def set_exception(self, exception: BaseException) -> None:
        """Set the exception that :meth:`result` raises, and call the callbacks."""
        self._exception = exception
        self._finish()

    def cancel(self) -> None:
        """Finish without a result; a result that comes later is dropped."""
        self._finish()

    def add_done_callback(self, callback: Callable[[Future[T]], object]) -> None:
        """Call *callback* with this future once it is done: now, or on the thread that spins."""
        if self._done:
            callback(self)
        else:
            self._callbacks.append(callback)

    def _finish(self) -> None:
        if not self._done:
            self._done = True
            callbacks, self._callbacks = self._callbacks, []
            for callback in callbacks:
                callback(self)


class CallbackQueue:
    """The callbacks of a node that are due, run by the thread that spins it.

    It is short without a limit of its own: of each subscription, service and timer one callback waits here at most.
    """

    def __init__(self) -> None:
        self._due: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()

    def put(self, work: Callable[[], None]) -> None:
        """Add *work*, from any thread."""
        self._due.put(work)

    def run_next(self, timeout: float | None = None) -> None:
        """Run the next callback, waiting for one up to *timeout* seconds; its exception is raised here."""
        with suppress(queue.Empty):
            work = self._due.get(timeout=timeout) if timeout is None or timeout > 0 else self._due.get_nowait()
            work()

    async def run(self, function: Callable[..., object], *args: object) -> object:
        """Run *function*, which may be a coroutine function, on the spinning thread and return its result.

        Called on the event loop. An exception is raised both here and on the spinning thread.
        """
        loop = asyncio.get_running_loop()
        outcome: asyncio.Future[object] = loop.create_future()

        def finish(set_outcome: Callable[[], None]) -> None:
            with suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(lambda: None if outcome.done() else set_outcome())

        def step(coroutine: Coroutine[Future[object], None, object] | None) -> None:
            if coroutine is None and outcome.done():
                return  # the node was closed meanwhile
            try:
                result = function(*args) if coroutine is None else coroutine.send(None)
            except StopIteration as stop:
                value = stop.value
                finish(lambda: outcome.set_result(value))
            except BaseException as exc:
                error = exc
                finish(lambda: outcome.set_exception(error))
                raise
            else:
                if coroutine is not None:
                    cast("Future[object]", result).add_done_callback(lambda _: self.put(lambda: step(coroutine)))
                elif iscoroutine(result):
                    step(result)
                else:
                    finish(lambda: outcome.set_result(result))

        self.put(lambda: step(None))
        return await outcome
