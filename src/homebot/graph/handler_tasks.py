"""The tasks of a node that the handlers of its services run in.

A handler takes its first step at once, within its caller's turn but as one of these tasks: ``asyncio.current_task()``
and the cancel scopes and time limits that it enters are that task's. Most handlers need no second step, so that their
callers wait for no task. A handler that waits goes on in the task, which is the node's: a caller that gives up or is
cancelled does not end it. All its steps see one copy of the context variables that its caller had.

Where no task is free, a handler begins in a new one, when the event loop comes to it. Tasks are used again: 8 of a node
are kept when they have nothing to do. How many more a service lets begin is :attr:`homebot.graph.Service.room`.
"""

from __future__ import annotations

import asyncio
from asyncio import current_task
from asyncio.tasks import _enter_task, _leave_task  # documented for those who step coroutines: "Extending asyncio"
from collections.abc import Callable, Coroutine, Iterator
from contextvars import Context, copy_context
from functools import partial
from inspect import isawaitable
from types import CoroutineType
from typing import TYPE_CHECKING, Any, TypeAlias, cast, final

import anyio

from homebot.errors import ServiceGoneError, ServiceTimeoutError
from homebot.graph.handler_steps import IS_DUE, NOT_BEGUN, HandlerWait, Handling, RemainingSteps, first_step
from homebot.isolation import is_cancelled, is_end_of, uncancel
from homebot.time_limits import TimeLimits

if TYPE_CHECKING:
    from homebot.graph.service import Service

__all__ = ["HandlerRun", "HandlerTask", "HandlerTasks", "StartTask"]

StartTask: TypeAlias = Callable[[Callable[[], Coroutine[object, object, None]]], None]

_MOST_FREE = 8


@final
class HandlerRun:
    """A call whose handler is at work in a task of the serving node; both know it as soon as it is made.

    Attributes:
        server: The service.
        task: The task.
        handler: The handler's coroutine.
        context: The context variables that it sees.
        waits_for: What it waits for since its first step, or NOT_BEGUN; IS_DUE where its task is woken when it is due.
        began: When it began, by the event loop's clock.
        outcome: For the caller: the response or a :class:`homebot.errors.ServiceError`. Done when the caller has left.
        has_ended: Whether the handler has ended.
    """

    __slots__ = (
        "__weakref__",
        "_end",
        "began",
        "context",
        "handler",
        "has_ended",
        "outcome",
        "server",
        "task",
        "waits_for",
    )

    def __init__(
        self, server: Service[Any, Any], task: HandlerTask, handler: Handling, context: Context, waits_for: object
    ) -> None:
        self.server = server
        self.task = task
        self.handler = handler
        self.context = context
        self.waits_for = waits_for
        loop = asyncio.get_running_loop()
        self.began = loop.time()
        self.outcome: asyncio.Future[object] = loop.create_future()
        self.has_ended = False
        self._end: anyio.Event | None = None
        task.run = self
        server.add_run(self)

    async def wait_for_end(self) -> None:
        """Wait until the handler has ended."""
        if not self.has_ended:
            self._end = self._end or anyio.Event()
            await self._end.wait()

    async def wait(self, timeout: float, on_left: Callable[[HandlerRun], None]) -> object:  # noqa: ASYNC109
        """Return the handler's outcome; a caller that is cancelled, or *timeout* seconds, leave it at work.

        Args:
            timeout: As of ``Client.call``.
            on_left: Called with this where it is left at work.
        """
        limits = self.server.tasks.limits
        limit = limits.set(timeout, partial(self._expire, timeout))
        try:
            return await self.outcome
        except BaseException:
            if not self.has_ended:
                self.task.caller = None
                self.outcome.cancel()
            elif not self.outcome.cancelled():  # it ended before the cancelled caller had its turn
                self.server.drop(self.outcome.result())
            raise
        finally:
            limits.discard(limit)
            if not self.has_ended:
                on_left(self)

    def end(self, outcome: object) -> None:
        """Give the handler's *outcome* to the caller, or drop it where the caller has left."""
        self.has_ended = True
        if self._end is not None:
            self._end.set()
        if self.outcome.done():
            self.server.drop(outcome)
        else:
            self.outcome.set_result(outcome)

    def _expire(self, timeout: float) -> None:
        if not self.outcome.done():
            self.task.caller = None
            name, is_closed = self.server.service_name, self.server.is_closed
            self.outcome.set_result(ServiceGoneError(name) if is_closed else ServiceTimeoutError(name, timeout))


@final
class HandlerTask:
    """A task that runs handlers, one after the other.

    Attributes:
        task: The task, once it has started.
        scope: Cancelling it ends the handler, and the task with it.
        run: The call whose handler is at work.
        caller: The task that waits for the handler, or None when none does any more.
        wait: What the task awaits while no handler is at work, or what that handler waits for since its first step.
    """

    __slots__ = ("_owner", "caller", "run", "scope", "task", "wait")

    def __init__(self, owner: HandlerTasks, caller: asyncio.Task[Any] | None) -> None:
        self.task: asyncio.Task[Any]
        self.scope = anyio.CancelScope()
        self.run: HandlerRun | None = None
        self.caller = caller
        self.wait = HandlerWait(asyncio.get_running_loop())
        self._owner = owner

    async def main(self) -> None:
        """Run handlers until the scope is cancelled or enough others are free."""
        task = self.task = cast("asyncio.Task[object]", asyncio.current_task())
        self._owner.by_task[task] = self
        try:
            with self.scope:
                free, error = self._owner.free, None
                while True:
                    if self.run is not None:
                        await self._serve(self.run, error)
                        if self.scope.cancel_called or len(free) >= _MOST_FREE:
                            return
                    free.append(self)
                    try:
                        await self.wait
                        error = None
                    except BaseException as exc:  # noqa: BLE001  # what the handler waits for failed, or it was cancelled
                        error = self._thrown(exc)
        finally:
            del self._owner.by_task[task]

    async def _serve(self, run: HandlerRun, error: BaseException | None) -> None:
        try:
            if run.waits_for is NOT_BEGUN and (run.server.is_closed or is_cancelled()):
                run.handler.close()
                run.end(ServiceGoneError(run.server.service_name))
            else:
                run.end(await RemainingSteps(run.handler, run.waits_for, run.context.run, error))
        except BaseException as exc:
            if is_end_of(self.task, exc):
                run.end(ServiceGoneError(run.server.service_name))
                raise
            if isinstance(exc, asyncio.CancelledError):
                uncancel()
            run.end(run.server.failed(exc, has_caller=not run.outcome.done()))
        finally:
            self.run = self.caller = None
            run.server.remove_run(run)

    def _thrown(self, error: BaseException) -> BaseException | None:
        """Return what is to be thrown into the handler, for its task was told *error* since the first step of it."""
        free = self._owner.free
        if isinstance(error, GeneratorExit):  # the task is thrown away, and what it has at work as well
            if self.run is not None:
                self.run.handler.close()
            raise error
        if self in free:  # else the next handler was given to it meanwhile
            free.remove(self)
        if self.run is not None:
            return error
        if is_cancelled():
            raise error
        uncancel()  # it was the last thing that a handler did
        return None


@final
class HandlerTasks:
    """The tasks of one node that run the handlers of its services.

    Args:
        by_task: Where all such tasks of a graph are found.

    Attributes:
        is_open: Whether the node runs. Where it does not, a handler runs in the task of its caller and ends with it.
        by_task: As above.
        free: Those that wait for a handler, which takes its first step as the last of them.
        limits: The time limits of the callers that wait.
    """

    def __init__(self, by_task: dict[asyncio.Task[Any], HandlerTask]) -> None:
        self.is_open = False
        self.by_task = by_task
        self.free: list[HandlerTask] = []
        self.limits = TimeLimits()
        self._loop: asyncio.AbstractEventLoop  # once it is open
        self._start_task: StartTask

    def open(self, start_task: StartTask) -> None:
        """Begin to run handlers, in tasks that *start_task* starts."""
        self.is_open = True
        self._loop = asyncio.get_running_loop()
        self._start_task = start_task

    def close(self) -> None:
        """Begin no further handlers; those at work end with their tasks."""
        self.is_open = False

    def begin(self, server: Service[Any, Any], result: object, cancel_with_caller: bool) -> object:  # noqa: FBT001
        """Let the handler whose coroutine is *result* take its first step.

        There is no time limit in place: most handlers need no second step, and a timer costs more than such a call.

        Returns:
            Its outcome; where it waits, its :class:`HandlerRun`, or the :class:`RemainingSteps` that are the caller's
            to take.
        """
        handler = result if type(result) is CoroutineType else _as_coroutine(result)
        if cancel_with_caller or not self.is_open or not server.outlives_callers:
            return first_step(handler)
        free, loop = self.free, self._loop
        caller = current_task(loop)
        if not free or caller is None:
            return self._start(server, handler, caller)
        host = free.pop()
        if host.wait.is_woken:  # it was cancelled
            return self._start(server, handler, caller)
        task, context = host.task, copy_context()
        host.caller = caller
        _leave_task(loop, caller)
        _enter_task(loop, task)
        try:
            waits_for = context.run(handler.send, None)
        except BaseException as exc:  # noqa: BLE001  # the caller's task is told nothing in the middle of a step
            _leave_task(loop, task)
            _enter_task(loop, caller)
            host.caller = None
            free.append(host)
            return exc.value if type(exc) is StopIteration else server.failed(exc)
        _leave_task(loop, task)
        _enter_task(loop, caller)
        run = HandlerRun(server, host, handler, context, waits_for)
        if host.wait.is_woken:  # its first step cancelled its task
            return run
        if host.wait.hand_on(waits_for):
            run.waits_for = IS_DUE
        else:  # nothing that a task can wait for: the task tells the handler
            host.wait.wake()
        return run

    def current(self) -> HandlerTask | None:
        """Return the task that runs now, if it is one that runs handlers."""
        task = asyncio.current_task()
        return None if task is None else self.by_task.get(task)

    def waiting_for_current(self) -> Iterator[object]:
        """Yield the current task, its :class:`HandlerTask` if it is one, the task that waits for that, and so on."""
        task = asyncio.current_task()
        while task is not None:
            yield task
            host = self.by_task.get(task)
            if host is None:
                return
            yield host
            task = host.caller

    def _start(self, server: Service[Any, Any], handler: Handling, caller: asyncio.Task[Any] | None) -> HandlerRun:
        host = HandlerTask(self, caller)
        run = HandlerRun(server, host, handler, copy_context(), NOT_BEGUN)
        self._start_task(host.main)
        return run


async def _as_coroutine(result: object) -> object:
    return await result if isawaitable(result) else result
