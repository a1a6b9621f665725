"""The calling end of a service."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Generator
from inspect import isawaitable
from types import CoroutineType
from typing import Generic, NoReturn, TypeVar

import anyio

from homebot.errors import (
    ClosedError,
    HomebotError,
    ServiceError,
    ServiceFailedError,
    ServiceGoneError,
    ServiceTimeoutError,
    ServiceUnavailableError,
    TypeMismatchError,
)
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.service import Service, ServiceSlot
from homebot.isolation import crash_of, error_text, is_cancelled
from homebot.messages.message import Message, ServiceType

__all__ = ["Client"]

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)

DEFAULT_TIMEOUT = 5.0

_NOT_YET = object()


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

    async def call(self, request: RequestT, timeout: float = DEFAULT_TIMEOUT) -> ResponseT:  # noqa: ASYNC109
        """Return the server's response to *request*.

        Args:
            request: What to ask.
            timeout: Seconds that the server may take, its waiting line included.

        Raises:
            ServiceUnavailableError: There is no server (at once, without waiting).
            ServiceFailedError: The server raised; its exception is the cause.
            ServiceGoneError: The server was closed while it worked.
            ServiceTimeoutError: No response within *timeout*.
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
        waits_for: object = _NOT_YET
        try:
            response = server.callback(request)
            if type(response) is not self._response_type:
                # The first step is taken without a time limit in place: most handlers need no second one, and a timer
                # costs more than such a call.
                handler = response if type(response) is CoroutineType else _as_coroutine(response)
                try:
                    waits_for = handler.send(None)
                except StopIteration as stop:
                    response = stop.value
                else:
                    response = await self._finish(server, handler, waits_for, timeout)
        except BaseException as exc:
            if (isinstance(exc, asyncio.CancelledError) and _is_cancelled()) or (
                isinstance(exc, GeneratorExit) and waits_for is not _NOT_YET
            ):
                raise
            raise self._failure(server, exc) from exc
        finally:
            if server.line:
                server.end_turn()
            else:
                server.is_busy = False
        if type(response) is self._response_type:
            return response
        raise _no_response(self.info.name, response)

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

    async def _finish(
        self,
        server: Service[RequestT, ResponseT],
        handler: Coroutine[object, object, object],
        waits_for: object,
        timeout: float,  # noqa: ASYNC109  # as call()
    ) -> object:
        """Run a handler that waits to its end; return its response, or the ServiceError that ended the call.

        Handing that error back keeps it apart from an error that the handler raised.
        """
        try:
            async with asyncio.timeout(timeout) as deadline:
                server.watch(deadline)
                rest = _Started(handler, waits_for)
                try:
                    return await rest
                except (TimeoutError, GeneratorExit) as exc:
                    if rest.is_closed:
                        raise
                    failure = self._failure(server, exc)
                    failure.__cause__ = exc
                    return failure
                finally:
                    server.unwatch(deadline)
        except TimeoutError:
            if server.is_closed:
                return ServiceGoneError(self.info.name)
            return ServiceTimeoutError(self.info.name, timeout)

    def _failure(self, server: Service[RequestT, ResponseT], error: BaseException) -> ServiceFailedError:
        """Return what the caller gets for the handler's *error*; one that is no answer counts as a failure too."""
        crash = crash_of(server.info.node, error)
        if not isinstance(error, HomebotError):
            server.on_failure(crash)
        if isinstance(error, asyncio.CancelledError):
            return ServiceFailedError(self.info.name, "something that its handler awaited was cancelled")
        return ServiceFailedError(self.info.name, error_text(crash))

    def _reject(self, request: object) -> NoReturn:
        raise TypeMismatchError(
            f"{self.info.name} takes a {self._request_type.__name__}, got a {type(request).__name__}"
        )

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"the client of {self.info.node} for {self.info.name} is closed")


class _Started:
    """The rest of a coroutine whose first step was taken by hand, to be awaited in the same task."""

    def __init__(self, coroutine: Coroutine[object, object, object], waits_for: object) -> None:
        self.is_closed = False  # thrown away with its caller, which is no GeneratorExit of its own
        self._coroutine = coroutine
        self._waits_for = waits_for

    def __await__(self) -> Generator[object, object, object]:
        coroutine, waits_for = self._coroutine, self._waits_for
        while True:
            try:
                try:
                    value = yield waits_for
                except GeneratorExit:
                    self.is_closed = True
                    coroutine.close()
                    raise
                except BaseException as exc:  # noqa: BLE001  # whatever the task is told belongs to the coroutine
                    waits_for = coroutine.throw(exc)
                else:
                    waits_for = coroutine.send(value)
            except StopIteration as stop:
                return stop.value


async def _as_coroutine(result: object) -> object:
    return await result if isawaitable(result) else result


def _is_cancelled() -> bool:
    """Return whether somebody cancelled this task, rather than something it waited for."""
    task = asyncio.current_task()
    return is_cancelled() or (task is not None and task.cancelling() > 0)


def _no_response(service: str, outcome: object) -> ServiceError:
    if isinstance(outcome, ServiceError):
        return outcome
    return ServiceFailedError(service, f"the server returned {outcome!r}, which is not its response type")
