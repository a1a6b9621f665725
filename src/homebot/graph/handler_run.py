"""A call of a service with a handler that waits: its task, its caller and its outcome."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextvars import ContextVar
from inspect import iscoroutine
from typing import Any, Final, Protocol, TypeAlias, final

import anyio

from homebot.errors import ServiceError, ServiceGoneError
from homebot.support.isolation import is_end_of, uncancel

__all__ = ["HandlerRun", "StartHandler", "calling_runs"]

_current: ContextVar[HandlerRun | None] = ContextVar("_current", default=None)

_UNSERVED: Final = object()
"""Outcome of a handler that was cancelled."""

StartHandler: TypeAlias = Callable[[Callable[[], Coroutine[object, object, None]]], bool]
"""Starts a task of the serving node; returns False if the node does not run."""


class Server(Protocol):
    """The service whose handler runs."""

    start: StartHandler

    @property
    def service_name(self) -> str:
        """The full name of the service."""

    @property
    def is_closed(self) -> bool:
        """True once it serves no longer."""

    def add_run(self, run: HandlerRun) -> None:
        """Count *run* among the handlers at work."""

    def remove_run(self, run: HandlerRun) -> None:
        """Count *run* no longer."""

    def failed(self, crash: BaseException, *, has_caller: bool) -> ServiceError:
        """Record the *crash* of a handler, and return the error for its caller."""

    def drop(self, outcome: object) -> None:
        """Count an *outcome* that has no caller."""


@final
class HandlerRun:
    """A handler that waits, from the call to its end.

    Attributes:
        outcome: The response or a :class:`homebot.errors.ServiceError`; cancelled if the caller left first.
        task: The task that runs the handler, or None before and after.
    """

    def __init__(self, server: Server, handler: Awaitable[object]) -> None:
        loop = asyncio.get_running_loop()
        self.server = server
        self.began = loop.time()
        self.outcome: asyncio.Future[object] = loop.create_future()
        self.task: asyncio.Task[Any] | None = None
        self._handler = handler
        self._parent = _run_of_current_task()
        self.has_ended = False
        self._is_answered = False
        self._is_cancelled = False
        self._stop: Callable[[], object] | None = None
        self._end_event: anyio.Event | None = None
        server.add_run(self)

    async def serve(self, *, is_callers_task: bool = False) -> None:
        """Run the handler in the current task: one of the serving node, or its caller's, with which it is cancelled."""
        token = _current.set(self)
        self.task = asyncio.current_task()
        outcome: object = _UNSERVED
        with anyio.CancelScope() as scope:
            self._stop = scope.cancel
            try:
                if self.server.is_closed or self._is_cancelled:
                    self._discard_handler()
                else:
                    outcome = await self._handler
            except BaseException as exc:
                if self._is_end(exc, is_callers_task=is_callers_task):
                    raise
                if isinstance(exc, asyncio.CancelledError):
                    uncancel()
                outcome = self.server.failed(exc, has_caller=not self.outcome.done())
            finally:
                _current.reset(token)
                self._end(outcome)

    def _is_end(self, error: BaseException, *, is_callers_task: bool) -> bool:
        """Return whether *error* ends this run: its cancellation, or that of its task."""
        is_cancelled = self._is_cancelled and isinstance(error, asyncio.CancelledError)
        return is_cancelled or is_end_of(self.task, error) or (is_callers_task and _is_cancelled_by_asyncio(error))

    def cancel(self) -> None:
        """Cancel the handler."""
        self._is_cancelled = True
        stop, self._stop = self._stop, None
        if stop is not None:
            stop()

    def abandon(self) -> None:
        """Drop the outcome: the caller was cancelled; the handler continues."""
        if self._is_answered:  # it ended before the cancelled caller had its turn
            self.server.drop(self.outcome.result())
        self.outcome.cancel()

    def end_call(self, error: ServiceError, *, cancels: bool) -> None:
        """End the call with *error*, unless it has ended; the handler continues unless *cancels*."""
        if not self.outcome.done():
            self.outcome.set_result(error)
        if cancels:
            self.cancel()

    def discard(self) -> None:
        """Drop a handler that no task runs."""
        self._discard_handler()
        self._end(_UNSERVED)

    async def wait_for_end(self) -> None:
        """Wait until the handler has ended."""
        if not self.has_ended:
            self._end_event = self._end_event or anyio.Event()
            await self._end_event.wait()

    @property
    def parent(self) -> HandlerRun | None:
        """The handler that waits for this one, or None if the caller is no handler or has left."""
        return None if self.outcome.done() else self._parent

    def _end(self, outcome: object) -> None:
        if outcome is _UNSERVED:
            outcome = ServiceGoneError(self.server.service_name)
        self.has_ended, self._stop = True, None
        self.task = None  # the loop holds this run in the context of each cancelled timer of the handler for a while
        if self._end_event is not None:
            self._end_event.set()
        if self.outcome.done():
            self.server.drop(outcome)
        else:
            self._is_answered = True
            self.outcome.set_result(outcome)
        self.server.remove_run(self)

    def _discard_handler(self) -> None:
        if iscoroutine(self._handler):
            self._handler.close()


def calling_runs() -> Iterator[HandlerRun]:
    """Yield the handler that runs in the current task, the handler that waits for that one, and so on."""
    run = _run_of_current_task()
    while run is not None:
        yield run
        run = run.parent


def _run_of_current_task() -> HandlerRun | None:
    """Return the handler of the current task; tasks started by a handler inherit its context, but are not its own."""
    run = _current.get()
    return None if run is None or run.task is None or run.task is not asyncio.current_task() else run


def _is_cancelled_by_asyncio(error: BaseException) -> bool:
    task = asyncio.current_task()
    return isinstance(error, asyncio.CancelledError) and task is not None and task.cancelling() > 0
