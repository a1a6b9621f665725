"""The calling end of a service."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Generic, NoReturn, TypeVar
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
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.handler_steps import RemainingSteps
from homebot.graph.handler_tasks import HandlerRun
from homebot.graph.service import Service, ServiceSlot
from homebot.isolation import is_cancelled
from homebot.messages.message import Message, ServiceType

__all__ = ["Client"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

DEFAULT_TIMEOUT = 5.0


class Client(Generic[RequestT, ResponseT]):
    """Calls one service. Calls may run concurrently, from any task.

    Attributes:
        info: The endpoint as the graph shows it.
    """

    def __init__(
        self,
        slot: ServiceSlot,
        service_type: ServiceType[RequestT, ResponseT],
        node: str,
        on_close: Callable[[], None],
    ) -> None:
        """Take what :meth:`homebot.graph.Node.create_client` gives; not for use by hand."""
        self.info = EndpointInfo(EntityKind.CLIENT, node, slot.name, service_type.ros_type)
        self._slot = slot
        self._on_close: Callable[[], None] | None = on_close
        self._closed = False
        self._left_at_work: WeakSet[HandlerRun] | None = None
        self._request_type = service_type.Request
        self._response_type = service_type.Response

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self.info.name

    def service_is_ready(self) -> bool:
        """Return whether the service has a server now."""
        return self._slot.server is not None

    async def wait_for_service(self, timeout: float | None = None) -> bool:  # noqa: ASYNC109  # rclpy's spelling
        """Wait until the service has a server; return False when *timeout* seconds pass first.

        Raises:
            ClosedError: The client is closed, or was while it waited.
        """
        with anyio.move_on_after(timeout):
            while self._slot.server is None:
                self._check_open()
                await self._slot.wait_for_change()
        return self.service_is_ready()

    async def call(
        self,
        request: RequestT,
        timeout: float = DEFAULT_TIMEOUT,  # noqa: ASYNC109
        cancel_with_caller: bool = False,  # noqa: FBT001, FBT002  # keyword-only would cost every call 15 ns
    ) -> ResponseT:
        """Return the server's response to *request*.

        The time limit ends the call, not the work: the handler goes on, and its late answer is dropped and counted. The
        same holds when the caller is cancelled.

        Args:
            request: What to ask.
            timeout: Seconds that the server may take, its waiting line included.
            cancel_with_caller: Whether the handler is cancelled when the time limit passes or the caller is cancelled;
                it then runs in the caller's task. To be given by name.

        Raises:
            ServiceUnavailableError: There is no server, or too many calls wait for it (at once, without waiting).
            ServiceFailedError: The server raised; its exception is the cause.
            ServiceGoneError: The server was closed while it worked.
            ServiceTimeoutError: No response within *timeout*; the server may still act.
            TypeMismatchError: *request* is not exactly of the service's request type.
            ClosedError: The client was closed.
        """
        server = self._slot.server
        if server is None:
            self._check_open()
            raise ServiceUnavailableError(self.info.name)
        if type(request) is not self._request_type:
            self._reject(request)
        if server.is_busy:
            timeout = await self._take_turn(server, timeout)
        else:
            server.is_busy = server.is_exclusive
        outcome: object = None
        try:
            outcome = server.callback(request)
            if type(outcome) is not self._response_type:
                outcome = server.tasks.begin(server, outcome, cancel_with_caller)
                if type(outcome) is RemainingSteps:
                    outcome = await self._finish(server, outcome, timeout)
        except BaseException as exc:
            if _is_end_of_call(exc, has_waited=type(outcome) is RemainingSteps):
                raise
            raise server.failed(exc) from exc
        finally:
            if server.line:
                server.end_turn()
            else:
                server.is_busy = server.room < 1
        if type(outcome) is self._response_type:
            return outcome
        if type(outcome) is HandlerRun:
            outcome = await outcome.wait(timeout, self._note_left)
            if type(outcome) is self._response_type:
                return outcome
        raise _no_response(self.info.name, outcome)

    async def wait_for_handlers(self) -> None:
        """Wait until no handler works any more on a call of this client that ran out of time."""
        for run in list(self._left_at_work or ()):
            await run.wait_for_end()

    def close(self) -> None:
        """Close the client. Twice is fine."""
        if not self._closed:
            self._closed = True
            slot, self._slot = self._slot, ServiceSlot(self._slot.name, self._slot.service_type)
            on_close, self._on_close = self._on_close, None  # it holds us: both would stay in memory
            if on_close is not None:
                on_close()
            slot.wake()

    async def _take_turn(self, server: Service[RequestT, ResponseT], timeout: float) -> float:  # noqa: ASYNC109
        """Wait in the server's line; return what is left of *timeout*."""
        now = asyncio.get_running_loop().time
        started = now()
        try:
            async with asyncio.timeout(timeout):
                await server.take_turn()
        except TimeoutError:
            raise ServiceTimeoutError(self.info.name, timeout) from None
        return timeout - (now() - started)

    def _note_left(self, run: HandlerRun) -> None:
        if self._left_at_work is None:
            self._left_at_work = WeakSet()
        self._left_at_work.add(run)

    async def _finish(
        self,
        server: Service[RequestT, ResponseT],
        rest: RemainingSteps,
        timeout: float,  # noqa: ASYNC109  # as call()
    ) -> object:
        """Run a handler that waits to its end in this task; return its response, or what ended the call.

        Handing that ServiceError back keeps it apart from an error that the handler raised.
        """
        try:
            async with asyncio.timeout(timeout) as deadline:
                server.watch(deadline)
                try:
                    return await rest
                except (TimeoutError, GeneratorExit) as exc:
                    if rest.is_closed:
                        raise
                    return server.failed(exc)
                finally:
                    server.unwatch(deadline)
        except TimeoutError:
            if server.is_closed:
                return ServiceGoneError(self.info.name)
            return ServiceTimeoutError(self.info.name, timeout)

    def _reject(self, request: object) -> NoReturn:
        raise TypeMismatchError(
            f"{self.info.name} takes a {self._request_type.__name__}, got a {type(request).__name__}"
        )

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"the client of {self.info.node} for {self.info.name} is closed")


def _is_end_of_call(error: BaseException, *, has_waited: bool) -> bool:
    """Return whether *error*, out of a handler in this task, ends the task or throws the call away."""
    if isinstance(error, asyncio.CancelledError):
        task = asyncio.current_task()
        return is_cancelled() or (task is not None and task.cancelling() > 0)
    return isinstance(error, GeneratorExit) and has_waited


def _no_response(service: str, outcome: object) -> ServiceError:
    if isinstance(outcome, ServiceError):
        return outcome
    return ServiceFailedError(service, f"the server returned {outcome!r}, which is not its response type")
