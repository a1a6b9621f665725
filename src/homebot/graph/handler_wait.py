"""The future that a task which runs handlers awaits between two of them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Generator
from contextvars import Context
from typing import Any, final

__all__ = ["HandlerWait"]


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
