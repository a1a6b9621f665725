"""Server of a service; a client calls its handler (:mod:`homebot.graph.client`).

A plain function is called in its caller's task. A handler that waits runs in a task of the serving node: it continues
after its caller's time limit, and its late answer is dropped and counted. Without ``concurrent`` one handler runs at a
time; further calls are queued.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextvars import ContextVar
from inspect import iscoroutine
from typing import Any, Final, Generic, TypeAlias, TypeVar, final

import anyio

from homebot.errors import (
    HomebotError,
    ServiceError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceUnavailableError,
    UsageError,
)
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity, OfferedEntity
from homebot.graph.failures import Failures
from homebot.messages.message import Message, ServiceType
from homebot.support.isolation import crash_of, error_text, is_end_of, uncancel

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT")

Handler: TypeAlias = Callable[[RequestT], ResponseT | Awaitable[ResponseT]]

StartHandler: TypeAlias = Callable[[Callable[[], Coroutine[object, object, None]]], bool]
"""Starts a task of the serving node; returns False if the node does not run."""

MAX_AT_WORK = 1000  # waiting handlers of a concurrent service, even after their callers' time limits
MAX_WAITING = 1000  # queued callers


class ServiceSlot:
    """A service name with its type, its server and its number of users; it exists while it is used."""

    def __init__(self, name: str, service_type: ServiceType[Any, Any]) -> None:
        self.name = name
        self.service_type = service_type
        self.server: Service[Any, Any] | None = None
        self.offered: OfferedEntity | None = None
        self.users = 0
        self._changed = asyncio.Event()

    @property
    def is_served(self) -> bool:
        """True if it has a server, or will have one with the first call."""
        return self.server is not None or (self.offered is not None and not self.offered.is_closed)

    def set_server(self, server: Service[Any, Any] | None) -> None:
        """Set the server and wake all waiting clients."""
        self.server = server
        self.wake()

    def wake(self) -> None:
        """Wake all tasks in :meth:`wait_for_change`."""
        self._changed.set()
        self._changed = asyncio.Event()

    async def wait_for_change(self) -> None:
        """Wait until a server or client is added or removed."""
        await self._changed.wait()


class Service(GraphEntity, Generic[RequestT, ResponseT]):
    """Serves the calls of one service name.

    Attributes:
        room: Number of further handlers that may begin to wait; without room, calls are queued.
        runs: The handlers that wait, in the order of their start, for reproducible runs.
    """

    def __init__(
        self,
        name: str,
        service_type: ServiceType[RequestT, ResponseT],
        node: str,
        callback: Handler[RequestT, ResponseT],
        *,
        concurrent: bool,
        cancel_with_caller: bool,
        start: StartHandler,
        on_close: Callable[[Any], None],
        failures: Failures,
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_service` instead."""
        super().__init__(EndpointInfo(EntityKind.SERVICE, node, name, service_type.ros_type), on_close)
        self.callback = callback
        self.cancel_with_caller = cancel_with_caller
        self.start = start
        self.room = MAX_AT_WORK if concurrent else 1
        self.is_exclusive = not concurrent
        self.line: deque[asyncio.Future[None]] = deque()
        self._failures = failures
        self.runs: dict[HandlerRun, None] = {}

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    def join_line(self) -> asyncio.Future[None]:
        """Return the turn of another call, for :meth:`wait_in_line`.

        Raises:
            ServiceUnavailableError: 1,000 calls wait already.
        """
        if len(self.line) >= MAX_WAITING:
            self._failures.refused_calls += 1
            raise ServiceUnavailableError(self.service_name, f"has {MAX_WAITING:,} calls waiting already")
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.line.append(turn)
        return turn

    async def wait_in_line(self, turn: asyncio.Future[None]) -> None:
        """Wait until it is *turn*; the caller begins its handler before it waits again.

        Raises:
            UsageError: The caller is this service's own handler, which would wait for itself.
            ServiceGoneError: The server was closed meanwhile.
        """
        try:
            if self.is_exclusive and any(run.server is self for run in calling_runs()):
                raise UsageError(f"the handler of {self.service_name} calls itself; create it with concurrent=True")
            await turn
        except BaseException:
            if turn in self.line:
                self.line.remove(turn)
            elif not turn.cancelled():
                self.room += 1
                self.call_next()
            raise
        self.room += 1
        if self.is_closed:
            raise ServiceGoneError(self.service_name)

    def call_next(self) -> None:
        """Reserve the free room for the next queued call."""
        while self.line and self.room > 0:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1  # returned when the caller wakes up
                turn.set_result(None)
                return

    def failed(self, error: BaseException, *, has_caller: bool = True) -> ServiceFailedError:
        """Return the error for the caller of a handler that raised *error*; an unexpected one counts as a failure."""
        reason = str(error)
        if not isinstance(error, HomebotError):
            crash = crash_of(self.info.node, error)
            cost = "its caller gets the error" if has_caller else "its caller had left"
            self._failures.record(self.info.node, f"handler of {self.service_name}", crash, cost)
            was_cancelled = isinstance(error, asyncio.CancelledError)
            reason = "something that its handler awaited was cancelled" if was_cancelled else error_text(crash)
        failure = ServiceFailedError(self.service_name, reason)
        failure.__cause__ = error
        return failure

    def drop(self, outcome: object) -> None:
        """Count a late *outcome*, except that of a closed service."""
        if isinstance(outcome, ServiceGoneError):
            return
        cause = outcome.__cause__ if isinstance(outcome, ServiceFailedError) else None
        error = cause if isinstance(cause, HomebotError) else None
        self._failures.count_late(self.info.node, self.service_name, error)

    def seconds_without_caller(self) -> float:
        """Return the age in seconds of the oldest handler without a caller, or 0."""
        now = asyncio.get_running_loop().time()
        return next((now - run.began for run in self.runs if run.outcome.done()), 0.0)

    def cancel_handlers(self) -> None:
        """Cancel all running handlers."""
        for run in tuple(self.runs):
            run.cancel()

    def close(self, *, finish: bool = False) -> None:
        """Stop serving: running handlers are cancelled, and pending calls end with ServiceGoneError. Idempotent.

        A handler that closes its own server still answers; with *finish* all running handlers do.
        """
        if self.is_closed:
            return
        super().close()
        own = next(calling_runs(), None)
        for run in () if finish else tuple(self.runs):
            if run is not own:
                run.end_call(ServiceGoneError(self.service_name), cancels=True)
        while self.line:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1
                turn.set_result(None)


_current: ContextVar[HandlerRun | None] = ContextVar("_current", default=None)

_UNSERVED: Final = object()
"""Outcome of a handler that was cancelled."""


@final
class HandlerRun:
    """A handler that waits, from the call to its end.

    Attributes:
        outcome: The response or a :class:`homebot.errors.ServiceError`; cancelled if the caller left first.
        task: The task that runs the handler; None before and after.
        ended: Set when the handler has ended.
    """

    def __init__(self, server: Service[Any, Any], handler: Awaitable[object]) -> None:
        loop = asyncio.get_running_loop()
        self.server = server
        self.began = loop.time()
        self.outcome: asyncio.Future[object] = loop.create_future()
        self.task: asyncio.Task[Any] | None = None
        self._handler = handler
        self._context_run, self._caller = _current.get(), asyncio.current_task()
        self.ended = asyncio.Event()
        self._is_answered = False
        self._scope = anyio.CancelScope()
        server.runs[self] = None
        server.room -= 1

    async def serve(self, *, is_callers_task: bool = False) -> None:
        """Run the handler in the current task: one of the serving node, or its caller's, with which it is cancelled."""
        token = _current.set(self)
        self.task = asyncio.current_task()
        outcome: object = _UNSERVED
        with self._scope:
            try:
                if self.server.is_closed or self._scope.cancel_called:
                    self._discard_handler()
                else:
                    outcome = await self._handler
            except BaseException as exc:
                is_cancelled = self._scope.cancel_called and isinstance(exc, asyncio.CancelledError)
                if is_cancelled or is_end_of(self.task, exc) or (is_callers_task and _is_cancelled_by_asyncio(exc)):
                    raise
                if isinstance(exc, asyncio.CancelledError):
                    uncancel()
                outcome = self.server.failed(exc, has_caller=not self.outcome.done())
            finally:
                _current.reset(token)
                self._end(outcome)

    def cancel(self) -> None:
        """Cancel the handler."""
        self._scope.cancel()

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

    @property
    def parent(self) -> HandlerRun | None:
        """The handler that waits for this one; None if the caller is not a handler or has left."""
        return None if self.outcome.done() else _run_of(self._context_run, self._caller)

    def _end(self, outcome: object) -> None:
        server = self.server
        if outcome is _UNSERVED:
            outcome = ServiceGoneError(server.service_name)
        self.task = self._caller = None  # cancelled timers of the handler keep this run alive in their context a while
        self.ended.set()
        if self.outcome.done():
            server.drop(outcome)
        else:
            self._is_answered = True
            self.outcome.set_result(outcome)
        del server.runs[self]
        server.room += 1
        if server.line:
            server.call_next()

    def _discard_handler(self) -> None:
        if iscoroutine(self._handler):
            self._handler.close()


def calling_runs() -> Iterator[HandlerRun]:
    """Yield the handler that runs in the current task, the handler that waits for it, and so on."""
    run = _run_of(_current.get(), asyncio.current_task())
    while run is not None:
        yield run
        run = run.parent


def _run_of(run: HandlerRun | None, task: asyncio.Task[Any] | None) -> HandlerRun | None:
    """Return *run* if *task* is its own: tasks started by a handler inherit its context, but are not its own."""
    return None if run is None or run.task is None or run.task is not task else run


def _is_cancelled_by_asyncio(error: BaseException) -> bool:
    task = asyncio.current_task()
    return isinstance(error, asyncio.CancelledError) and task is not None and task.cancelling() > 0
