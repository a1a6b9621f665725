"""The steps of a handler, of which the first is taken by hand, within the turn of its caller.

:class:`RemainingSteps` are the others; :class:`HandlerWait` is what their task awaits meanwhile, so that it is woken by
what the handler waits for since its first step.
"""

from __future__ import annotations

import asyncio
import operator
from collections.abc import Callable, Coroutine, Generator
from contextvars import Context
from inspect import CO_COROUTINE
from opcode import opmap
from types import FunctionType, MethodType
from typing import Any, Final, TypeAlias, final

__all__ = ["IS_DUE", "NOT_BEGUN", "HandlerWait", "Handling", "RemainingSteps", "first_step", "may_wait"]

Handling: TypeAlias = Coroutine[object, object, object]
"""A handler at work."""

NOT_BEGUN: Final = object()
"""In the place of what a coroutine waits for: its first step is still to be taken."""

IS_DUE: Final = object()
"""Likewise: what it waited for has come, so that it goes on at once."""

_AWAIT = opmap["SEND"]
"""The instruction that every ``await``, ``async with`` and ``async for`` is compiled to."""


def may_wait(callback: object) -> bool:
    """Return whether what *callback* returns may wait; it cannot where it is a coroutine function without an await."""
    function = callback.__func__ if isinstance(callback, MethodType) else callback
    if not isinstance(function, FunctionType) or not function.__code__.co_flags & CO_COROUTINE:
        return True
    return _AWAIT in function.__code__.co_code[::2]


@final
class RemainingSteps:
    """The rest of a coroutine, to be awaited in the task in which it took its first step.

    Args:
        coroutine: The coroutine.
        waits_for: What its first step waits for, NOT_BEGUN or IS_DUE.
        run: Calls a function with arguments, in the context that the coroutine's steps run in.
        error: What to throw into it first, instead of waiting.

    Attributes:
        is_closed: Whether it was thrown away from outside, which is no GeneratorExit of its own.
    """

    def __init__(
        self,
        coroutine: Handling,
        waits_for: object,
        run: Callable[..., Any] = operator.call,  # as Context.run
        error: BaseException | None = None,
    ) -> None:
        self.is_closed = False
        self._coroutine = coroutine
        self._waits_for = waits_for
        self._run = run
        self._error = error

    def __await__(self) -> Generator[object, object, object]:
        coroutine, run, waits_for = self._coroutine, self._run, self._waits_for
        try:
            if self._error is not None:
                waits_for = run(coroutine.throw, self._error)
            elif waits_for is NOT_BEGUN or waits_for is IS_DUE:
                waits_for = run(coroutine.send, None)
            while True:
                try:
                    value = yield waits_for
                except GeneratorExit:
                    self.is_closed = True
                    run(coroutine.close)
                    raise
                except BaseException as exc:  # noqa: BLE001  # whatever the task is told belongs to the coroutine
                    waits_for = run(coroutine.throw, exc)
                else:
                    waits_for = run(coroutine.send, value)
        except StopIteration as stop:
            return stop.value
        finally:
            self._error = None


def first_step(coroutine: Handling) -> object:
    """Let *coroutine* take its first step in the current task; return its outcome, or the steps that remain."""
    try:
        waits_for = coroutine.send(None)
    except StopIteration as stop:
        return stop.value
    return RemainingSteps(coroutine, waits_for)


@final
class HandlerWait(asyncio.Future[None]):
    """A future that is never done itself: it hands the wake-up of the task that awaits it on to another future.

    The first step of a handler is taken outside of its task. To let the task await what the handler waits for, the task
    would have to be stepped, which takes a turn of the event loop. It is woken by that future directly instead.

    Attributes:
        is_woken: Whether the task goes on with the next turn of the event loop: it is due, or was cancelled while idle.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(loop=loop)
        self._wake_up: Callable[[asyncio.Future[Any]], object]
        self._context: Context | None = None
        self._now: asyncio.Future[None] = loop.create_future()
        self._now.set_result(None)
        self._waits_for: asyncio.Future[Any] | None = None
        self.is_woken = False

    def __await__(self) -> Generator[Any, None, None]:
        self._waits_for, self.is_woken = None, False
        self._asyncio_future_blocking = True  # as every future that is awaited
        yield self

    __iter__ = __await__

    def add_done_callback(  # type: ignore[override]
        self, wake_up: Callable[[asyncio.Future[Any]], object], /, *, context: Context | None = None
    ) -> None:
        """Take the wake-up of the task; the task calls this when it begins to wait."""
        self._wake_up, self._context = wake_up, context

    def done(self) -> bool:
        """Return whether what the handler waits for is done, so that a cancellation would come too late for it."""
        return self._waits_for is not None and self._waits_for.done()

    def wake(self) -> None:
        """Let the task go on with the next turn of the event loop."""
        self._wake_by(self._now)

    def hand_on(self, waits_for: object) -> bool:
        """Let the task go on when *waits_for* is done, with its error if it has one; return whether that is possible.

        Args:
            waits_for: What a coroutine waits for; None for the next turn of the event loop.
        """
        if waits_for is None:
            self.wake()
            return True
        if (
            not isinstance(waits_for, asyncio.Future)
            or not waits_for._asyncio_future_blocking  # noqa: SLF001 - part of the protocol
            or waits_for.get_loop() is not self.get_loop()
        ):
            return False
        waits_for._asyncio_future_blocking = False  # noqa: SLF001 - likewise: it was awaited properly
        self._waits_for = waits_for
        waits_for.add_done_callback(self._wake_up, context=self._context)
        return True

    def cancel(self, msg: Any | None = None) -> bool:
        """Cancel what the task waits for; what a task does that is cancelled. Return whether it will be told."""
        if self._waits_for is not None:
            return self._waits_for.cancel(msg=msg)
        if self.is_woken:
            return False
        cancelled: asyncio.Future[None] = self.get_loop().create_future()
        cancelled.cancel(msg=msg)
        self._wake_by(cancelled)
        return True

    def _wake_by(self, future: asyncio.Future[None]) -> None:
        self.is_woken = True
        self.get_loop().call_soon(self._wake_up, future, context=self._context)
