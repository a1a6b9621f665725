"""Client of a service."""

from asyncio import Future
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from inspect import isawaitable
from typing import Any, Generic, TypeVar
from weakref import WeakSet

import anyio

from homebot.errors import (
    ClosedError,
    ServiceError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.service import HandlerRun, Service, ServiceSlot
from homebot.messages.message import Message, ServiceType
from homebot.support.time_limits import TimeLimits

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT")

DEFAULT_TIMEOUT = 5.0


class Client(GraphEntity, Generic[RequestT, ResponseT]):
    """Calls one service. Calls may run concurrently, from any task."""

    def __init__(
        self,
        slot: ServiceSlot,
        service_type: ServiceType[RequestT, ResponseT],
        node: str,
        on_close: Callable[[Any], None],
        limits: TimeLimits,
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_client` instead."""
        super().__init__(EndpointInfo(EntityKind.CLIENT, node, slot.name, service_type.ros_type), on_close)
        self._slot = slot
        self._left_at_work: WeakSet[HandlerRun] = WeakSet()
        self._limits = limits
        self.service_type = service_type
        self._request_type = service_type.Request
        self._answer_type = service_type.answer_type()

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    def service_is_ready(self) -> bool:
        """Return whether the service has a server now."""
        return self._slot.is_served

    async def wait_for_service(self, timeout: float | None = None) -> bool:  # noqa: ASYNC109  # rclpy's spelling
        """Wait until the service has a server; return False after *timeout* seconds.

        Raises:
            ClosedError: The client is closed.
        """
        with anyio.move_on_after(timeout):
            while not self._slot.is_served:
                self._check_open()
                await self._slot.wait_for_change()
        return self.service_is_ready()

    async def call(
        self,
        request: RequestT,
        timeout: float = DEFAULT_TIMEOUT,  # noqa: ASYNC109
        *,
        cancel_with_caller: bool = False,
    ) -> ResponseT:
        """Return the server's response to *request*.

        The time limit, or a cancellation of the caller, ends the call but not the work: the handler continues, and its
        late answer is dropped and counted.

        Args:
            timeout: Seconds that the server may take, including the time in its queue.
            cancel_with_caller: Whether the handler is cancelled when the time limit passes or the caller is cancelled;
                it then runs in the caller's task.

        Raises:
            ServiceUnavailableError: There is no server, or too many calls wait for it (at once, without waiting).
            ServiceFailedError: The server raised; its exception is the cause.
            ServiceGoneError: The server was closed while it worked.
            ServiceTimeoutError: No response within *timeout*; the server may still act.
            TypeMismatchError: *request* is not exactly of the service's request type.
            ClosedError: The client was closed.
        """
        server = self._slot.server
        if server is None and self._slot.offered is not None:
            await self._slot.offered.begin()
            server = self._slot.server
        if server is None:
            self._check_open()
            raise ServiceUnavailableError(self.info.name)
        if type(request) is not self._request_type:
            raise TypeMismatchError(
                f"{self.info.name} takes a {self._request_type.__name__}, got a {type(request).__name__}"
            )
        if server.room < 1:
            timeout = await self._wait_in_line(server, timeout)
        try:
            outcome: object = server.callback(request)
        except BaseException as exc:
            server.call_next()
            raise server.failed(exc) from exc
        if type(outcome) is not self._answer_type and isawaitable(outcome):
            is_bound = cancel_with_caller or server.cancel_with_caller
            outcome = await self._outcome_of(HandlerRun(server, outcome), timeout, is_bound=is_bound)
        elif server.line:
            server.call_next()  # an immediate answer takes no room
        if isinstance(outcome, self._answer_type):
            return outcome
        if isinstance(outcome, ServiceError):
            raise outcome
        problem = f"the server returned {outcome!r}, which is not its response type"
        raise ServiceFailedError(self.info.name, problem)

    def send(self, request: RequestT) -> None:
        """Start a call without waiting: its outcome is dropped, and so is the request if no server has room for it."""
        if self._slot.offered is not None:
            self._slot.offered.start()
        server = self._slot.server
        if server is None:
            return
        if server.room > 0:
            _begin(server, request)
            return
        with suppress(ServiceUnavailableError):  # counted
            turn = server.join_line()
            if not server.start(partial(_begin_in_turn, server, request, turn)):
                server.line.remove(turn)

    async def wait_for_handlers(self) -> None:
        """Wait until all handlers that still work on abandoned calls of this client have ended."""
        for run in list(self._left_at_work):
            await run.ended.wait()

    def close(self) -> None:
        """Close the client. Idempotent."""
        if not self.is_closed:
            slot, self._slot = self._slot, ServiceSlot(self._slot.name, self._slot.service_type)
            super().close()
            slot.wake()

    async def _wait_in_line(self, server: Service[RequestT, ResponseT], timeout: float) -> float:  # noqa: ASYNC109
        """Wait for room at the server; return the rest of *timeout*."""
        deadline = anyio.current_time() + timeout
        with anyio.move_on_after(timeout):
            await server.wait_in_line(server.join_line())
            return deadline - anyio.current_time()
        raise ServiceTimeoutError(self.info.name, timeout)

    async def _outcome_of(self, run: HandlerRun, timeout: float, *, is_bound: bool) -> object:  # noqa: ASYNC109
        """Return the response of the handler, or the ServiceError that ended the call.

        Apart from :meth:`call`, as the variables of a closure cost a call that does not wait a quarter of its time.

        Args:
            is_bound: Whether the handler ends with this call, as it also does if the serving node does not run.
        """
        is_bound = is_bound or not run.server.start(run.serve)
        limit = self._limits.set(timeout, lambda: run.end_call(self._time_error(run, timeout), cancels=is_bound))
        try:
            if is_bound:
                await run.serve(is_callers_task=True)
            return await run.outcome
        except BaseException:
            run.abandon()
            raise
        finally:
            self._limits.discard(limit)
            if not run.ended.is_set():
                self._left_at_work.add(run)

    def _time_error(self, run: HandlerRun, timeout: float) -> ServiceError:
        name = self.info.name
        return ServiceGoneError(name) if run.server.is_closed else ServiceTimeoutError(name, timeout)

    def _check_open(self) -> None:
        if self.is_closed:
            raise ClosedError(f"the client of {self.info.node} for {self.info.name} is closed")


def _begin(server: Service[Any, Any], request: Message) -> None:
    """Begin the handler of a call without a caller."""
    try:
        outcome: object = server.callback(request)
    except Exception as exc:  # noqa: BLE001 - recorded as the server's failure
        server.failed(exc, has_caller=False)
    else:
        if isawaitable(outcome):
            run = HandlerRun(server, outcome)
            run.abandon()
            if not server.start(run.serve):
                run.discard()


async def _begin_in_turn(server: Service[Any, Any], request: Message, turn: Future[None]) -> None:
    with suppress(ServiceGoneError):
        await server.wait_in_line(turn)
        _begin(server, request)
        server.call_next()  # an immediate answer takes no room
