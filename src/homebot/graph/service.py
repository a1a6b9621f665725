"""The answering end of a service; a client calls its handler (:mod:`homebot.graph.client`).

A handler runs in a task of the node that serves (:mod:`homebot.graph.handler_tasks`): it is not cancelled with its
caller, and goes on when the caller's time limit has passed. Its late answer is dropped and counted. Without
``concurrent`` one handler is at work at a time: the next call begins when it has ended. The others wait in line.
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
from homebot.graph.handler_steps import may_wait
from homebot.graph.handler_tasks import HandlerRun, HandlerTasks
from homebot.graph.service_counts import ServiceReports
from homebot.isolation import crash_of, error_text
from homebot.messages.message import Message, ServiceType

__all__ = ["Handler", "Service", "ServiceSlot"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

Handler: TypeAlias = Callable[[RequestT], ResponseT | Awaitable[ResponseT]]

MAX_AT_WORK = 1000  # handlers of a concurrent service that wait, their callers' time limits passed or not
MAX_WAITING = 1000  # callers in line


class ServiceSlot:
    """A service name: its type, its one server, its clients; it exists while anybody uses it.

    Attributes:
        name: Full name.
        service_type: The type of its requests and responses.
        server: Who serves now, or None.
        users: Clients and server together.
    """

    def __init__(self, name: str, service_type: ServiceType[Any, Any]) -> None:
        self.name = name
        self.service_type = service_type
        self.server: Service[Any, Any] | None = None
        self.users = 0
        self._waiters: dict[asyncio.Future[None], None] = {}  # in the order of coming, so that runs are alike

    def set_server(self, server: Service[Any, Any] | None) -> None:
        """Make *server* the one that serves, and wake whoever waits for a change."""
        self.server = server
        self.wake()

    def wake(self) -> None:
        """Let everybody in :meth:`wait_for_change` look again."""
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(None)

    async def wait_for_change(self) -> None:
        """Wait until a server or a client came or went."""
        waiter = asyncio.get_running_loop().create_future()
        self._waiters[waiter] = None
        try:
            await waiter
        finally:
            self._waiters.pop(waiter, None)


class Service(Generic[RequestT, ResponseT]):
    """Serves the calls of one service name.

    Attributes:
        info: The endpoint as the graph shows it.
        callback: What answers a request.
        outlives_callers: Whether a handler may go on when its caller has left.
        tasks: The tasks that handlers run in.
        room: How many more handlers may begin to work in tasks; where there is none, further calls wait in line.
        is_exclusive: Whether one call is served at a time.
        is_busy: Whether the next call must wait in line.
        is_closed: Whether it stopped serving.
        line: The calls that wait for their turn.
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
        tasks: HandlerTasks,
        on_close: Callable[[], None],
        reports: ServiceReports,
    ) -> None:
        """Take what :meth:`homebot.graph.Node.create_service` gives; not for use by hand."""
        self.info = EndpointInfo(EntityKind.SERVICE, node, name, service_type.ros_type)
        self.callback = callback
        self.outlives_callers = may_wait(callback) and not cancel_with_caller
        self.tasks = tasks
        self.room = MAX_AT_WORK if concurrent else 1
        self.is_exclusive = not concurrent
        self.is_busy = False
        self.is_closed = False
        self.line: deque[asyncio.Future[None]] = deque()
        self._reports = reports
        self._on_close: Callable[[], None] | None = on_close
        self._runs: dict[HandlerRun, None] = {}  # in the order of beginning, so that runs are alike
        self._owner: object = None
        self._deadlines: set[asyncio.Timeout] = set()

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    async def take_turn(self) -> None:
        """Wait until there is room for another call, then hold it; :meth:`end_turn` gives it back.

        Raises:
            UsageError: The call comes from this service's own handler, which would wait for itself.
            ServiceUnavailableError: 1,000 calls wait already.
            ServiceGoneError: The server was closed meanwhile.
        """
        if self.is_exclusive and self._is_called_by_itself():
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
                self.end_turn()
            raise
        self.room += 1
        if self.is_closed:
            raise ServiceGoneError(self.service_name)
        self._owner = None

    def end_turn(self) -> None:
        """Hand the service to the next in line, if there is room."""
        while self.line and self.room > 0:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1  # given back when the turn is taken
                self._owner = turn
                turn.set_result(None)
                return
        self.is_busy = self.room < 1

    def add_run(self, run: HandlerRun) -> None:
        """Count a handler that is at work in a task."""
        self._runs[run] = None
        self._owner = run.task
        self.room -= 1

    def remove_run(self, run: HandlerRun) -> None:
        """Note that a handler has ended."""
        del self._runs[run]
        self._owner = None
        self.room += 1
        if self.line:
            self.end_turn()
        else:
            self.is_busy = self.room < 1

    def watch(self, deadline: asyncio.Timeout) -> None:
        """Remember the limit of a call whose handler waits in its caller's task: closing the server ends it at once."""
        self._owner = asyncio.current_task()
        self._deadlines.add(deadline)

    def unwatch(self, deadline: asyncio.Timeout) -> None:
        """Forget *deadline*: its call ended."""
        self._owner = None
        self._deadlines.discard(deadline)

    def failed(self, error: BaseException, *, has_caller: bool = True) -> ServiceFailedError:
        """Return what the caller gets for the handler's *error*; one that is no answer counts as a failure too."""
        crash = crash_of(self.info.node, error)
        if not isinstance(error, HomebotError):
            self._reports.report_failure(crash, has_caller=has_caller)
        was_cancelled = isinstance(error, asyncio.CancelledError)
        reason = "something that its handler awaited was cancelled" if was_cancelled else error_text(crash)
        failure = ServiceFailedError(self.service_name, reason)
        failure.__cause__ = error
        return failure

    def drop(self, outcome: object) -> None:
        """Count an *outcome* of a handler that nobody waits for any more; to have been closed is none."""
        if isinstance(outcome, ServiceGoneError):
            return
        cause = outcome.__cause__ if isinstance(outcome, ServiceFailedError) else None
        self._reports.report_late(cause if isinstance(cause, HomebotError) else None)

    def seconds_without_caller(self) -> float:
        """Return how long the oldest handler has been at work whose caller has left; 0 where there is none."""
        now = asyncio.get_running_loop().time()
        return next((now - run.began for run in self._runs if run.outcome.done()), 0.0)

    def close(self) -> None:
        """Stop serving: handlers at work are cancelled, and calls under way end with ServiceGoneError.

        A handler that closes its own server goes on to its answer. Twice is fine.
        """
        if self.is_closed:
            return
        self.is_closed = True
        on_close, self._on_close = self._on_close, None  # it holds us: both would stay in memory
        if on_close is not None:
            on_close()
        if self._runs:
            current = self.tasks.current()
            for run in tuple(self._runs):
                if run.task is not current:
                    run.task.scope.cancel()
        now = asyncio.get_running_loop().time() if self._deadlines else 0.0
        for deadline in self._deadlines:
            if not deadline.expired():
                deadline.reschedule(now)
        while self.line:
            turn = self.line.popleft()
            if not turn.done():
                self.room -= 1
                turn.set_result(None)

    def _is_called_by_itself(self) -> bool:
        """Return whether the handler at work waits for the current task: it would wait for itself."""
        if self._owner is None:  # its first step runs right now, so that it called
            return True
        return any(one is self._owner for one in self.tasks.waiting_for_current())
