"""The answering end of a service.

A handler runs in the task of its caller, so a call that needs no waiting costs no task and no timer, and cancelling the
caller cancels the handler. Without ``concurrent`` one call is served at a time and the others wait in line.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Generic, TypeAlias, TypeVar

from homebot.errors import ServiceGoneError, ServiceUnavailableError, UsageError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.messages.message import Message, ServiceType

__all__ = ["Handler", "Service", "ServiceSlot"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

Handler: TypeAlias = Callable[[RequestT], ResponseT | Awaitable[ResponseT]]

MAX_WAITING = 1000  # callers in line for a service that serves one at a time


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
        is_exclusive: Whether one call is served at a time.
        is_busy: Whether an exclusive service serves a call now.
        is_closed: Whether it stopped serving.
        on_failure: Told of what the handler let through, but for errors of homebot, which are its answer.
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
        on_close: Callable[[], None],
        on_failure: Callable[[Exception], None],
    ) -> None:
        """Take what :meth:`homebot.graph.Node.create_service` gives; not for use by hand."""
        self.info = EndpointInfo(EntityKind.SERVICE, node, name, service_type.ros_type)
        self.callback = callback
        self.is_exclusive = not concurrent
        self.is_busy = False
        self.is_closed = False
        self.on_failure = on_failure
        self._on_close: Callable[[], None] | None = on_close
        self.line: deque[tuple[asyncio.Future[None], asyncio.Task[object] | None]] = deque()
        self._owner: asyncio.Task[object] | None = None
        self._deadlines: set[asyncio.Timeout] = set()

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    async def take_turn(self) -> None:
        """Wait until no other call is served, then hold the service; :meth:`end_turn` gives it back.

        Raises:
            UsageError: The call comes from this service's own handler, which would wait for itself.
            ServiceUnavailableError: 1,000 calls wait already.
            ServiceGoneError: The server was closed meanwhile.
        """
        task = asyncio.current_task()
        if self._owner is None or self._owner is task:  # no owner yet: its handler runs right now, so it called us
            raise UsageError(f"the handler of {self.service_name} calls itself; create it with concurrent=True")
        if len(self.line) >= MAX_WAITING:
            raise ServiceUnavailableError(self.service_name, f"has {MAX_WAITING:,} calls waiting already")
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        place = (turn, task)
        self.line.append(place)
        try:
            await turn
        except asyncio.CancelledError:
            if place in self.line:
                self.line.remove(place)
            elif not turn.cancelled():
                self.end_turn()
            raise
        if self.is_closed:
            raise ServiceGoneError(self.service_name)
        self._owner = None

    def end_turn(self) -> None:
        """Hand the service to the next in line."""
        while self.line:
            turn, task = self.line.popleft()
            if not turn.done():
                self._owner = task
                turn.set_result(None)
                return
        self.is_busy = False

    def watch(self, deadline: asyncio.Timeout) -> None:
        """Remember the time limit of a call whose handler waits: closing the server lets it expire at once."""
        self._owner = asyncio.current_task()
        self._deadlines.add(deadline)

    def unwatch(self, deadline: asyncio.Timeout) -> None:
        """Forget *deadline*: its call ended."""
        self._owner = None
        self._deadlines.discard(deadline)

    def close(self) -> None:
        """Stop serving: calls under way end with ServiceGoneError. Twice is fine."""
        if self.is_closed:
            return
        self.is_closed = True
        on_close, self._on_close = self._on_close, None  # it holds us: both would stay in memory
        if on_close is not None:
            on_close()
        now = asyncio.get_running_loop().time() if self._deadlines else 0.0
        for deadline in self._deadlines:
            if not deadline.expired():
                deadline.reschedule(now)
        while self.line:
            turn, _ = self.line.popleft()
            if not turn.done():
                turn.set_result(None)
