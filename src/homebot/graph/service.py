"""The answering end of a service; a client calls its handler (:mod:`homebot.graph.client`).

A plain function is called in its caller's task. A handler that waits runs in a task of the serving node
(:mod:`homebot.graph.handler_run`): it continues after its caller's time limit, and its late answer is dropped and
counted. Without ``concurrent`` one handler is at work at a time; further calls wait in line.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Generic, TypeAlias, TypeVar

from homebot.errors import (
    HomebotError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceUnavailableError,
    UsageError,
)
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.failures import ServiceReports
from homebot.graph.handler_run import HandlerRun, StartHandler, calling_runs
from homebot.messages.message import Message, ServiceType
from homebot.support.isolation import crash_of, error_text

__all__ = ["Handler", "Service", "ServiceSlot"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT")

Handler: TypeAlias = Callable[[RequestT], ResponseT | Awaitable[ResponseT]]

MAX_AT_WORK = 1000  # handlers of a concurrent service that wait, their callers' time limits passed or not
MAX_WAITING = 1000  # callers in line


class ServiceSlot:
    """A service name with its type, its server and its number of users; it exists while it is used."""

    def __init__(self, name: str, service_type: ServiceType[Any, Any]) -> None:
        self.name = name
        self.service_type = service_type
        self.server: Service[Any, Any] | None = None
        self.users = 0
        self._waiters: dict[asyncio.Future[None], None] = {}  # in order of arrival, for reproducible runs

    def set_server(self, server: Service[Any, Any] | None) -> None:
        """Set the server and wake all waiting clients."""
        self.server = server
        self.wake()

    def wake(self) -> None:
        """Wake all tasks in :meth:`wait_for_change`."""
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(None)

    async def wait_for_change(self) -> None:
        """Wait until a server or client is added or removed."""
        waiter = asyncio.get_running_loop().create_future()
        self._waiters[waiter] = None
        try:
            await waiter
        finally:
            self._waiters.pop(waiter, None)


class Service(Generic[RequestT, ResponseT]):
    """Serves the calls of one service name.

    Attributes:
        room: Number of further handlers that may begin to wait; without room, calls wait in line.
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
        on_close: Callable[[], None],
        reports: ServiceReports,
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_service` instead."""
        self.info = EndpointInfo(EntityKind.SERVICE, node, name, service_type.ros_type)
        self.callback = callback
        self.cancel_with_caller = cancel_with_caller
        self.start = start
        self.room = MAX_AT_WORK if concurrent else 1
        self.is_exclusive = not concurrent
        self.is_closed = False
        self.line: deque[asyncio.Future[None]] = deque()
        self._reports = reports
        self._on_close: Callable[[], None] | None = on_close
        self._runs: dict[HandlerRun, None] = {}  # in order of start, for reproducible runs

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    async def wait_in_line(self) -> None:
        """Wait until there is room for another call; the caller begins its handler before it waits again.

        Raises:
            UsageError: The call comes from this service's own handler, which would wait for itself.
            ServiceUnavailableError: 1,000 calls wait already.
            ServiceGoneError: The server was closed meanwhile.
        """
        if self.is_exclusive and any(run.server is self for run in calling_runs()):
            raise UsageError(f"the handler of {self.service_name} calls itself; create it with concurrent=True")
        if len(self.line) >= MAX_WAITING:
            self._reports.report_refusal()
            raise ServiceUnavailableError(self.service_name, f"has {MAX_WAITING:,} calls waiting already")
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.line.append(turn)
        try:
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
        """Reserve the free room for the next call in line."""
        while self.line and self.room > 0:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1  # returned when the caller wakes up
                turn.set_result(None)
                return

    def add_run(self, run: HandlerRun) -> None:
        """Count a handler at work."""
        self._runs[run] = None
        self.room -= 1

    def remove_run(self, run: HandlerRun) -> None:
        """Remove a handler that has ended."""
        del self._runs[run]
        self.room += 1
        self.call_next()

    def failed(self, error: BaseException, *, has_caller: bool = True) -> ServiceFailedError:
        """Return the error for the caller of a handler that raised *error*; an unexpected one counts as a failure."""
        crash = crash_of(self.info.node, error)
        if not isinstance(error, HomebotError):
            self._reports.report_failure(crash, has_caller=has_caller)
        was_cancelled = isinstance(error, asyncio.CancelledError)
        reason = "something that its handler awaited was cancelled" if was_cancelled else error_text(crash)
        failure = ServiceFailedError(self.service_name, reason)
        failure.__cause__ = error
        return failure

    def drop(self, outcome: object) -> None:
        """Count a late *outcome*; the end of a closed service is none."""
        if isinstance(outcome, ServiceGoneError):
            return
        cause = outcome.__cause__ if isinstance(outcome, ServiceFailedError) else None
        self._reports.report_late(cause if isinstance(cause, HomebotError) else None)

    def seconds_without_caller(self) -> float:
        """Return the age in seconds of the oldest handler without a caller, or 0."""
        now = asyncio.get_running_loop().time()
        return next((now - run.began for run in self._runs if run.outcome.done()), 0.0)

    def cancel_handlers(self) -> None:
        """Cancel all handlers at work."""
        for run in tuple(self._runs):
            run.cancel()

    def close(self, *, finish: bool = False) -> None:
        """Stop serving: handlers at work are cancelled, and calls under way end with ServiceGoneError.

        A handler that closes its own server still answers; with *finish* all handlers at work do. Idempotent.
        """
        if self.is_closed:
            return
        self.is_closed = True
        on_close, self._on_close = self._on_close, None  # breaks a reference cycle
        if on_close is not None:
            on_close()
        own = next(calling_runs(), None)
        for run in () if finish else tuple(self._runs):
            if run is not own:
                run.end_call(ServiceGoneError(self.service_name), cancels=True)
        while self.line:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1
                turn.set_result(None)
