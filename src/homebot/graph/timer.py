"""A callback at a steady rate.

As in ROS: each call is due one period after the last *due* time, so that the rate does not drift; periods that pass
while the callback still runs are skipped.
"""

import asyncio
from collections.abc import Awaitable, Callable

import anyio

from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.support.isolation import is_end_of


class Timer:
    """Calls a function once per period while its node runs.

    Attributes:
        skipped: Periods that passed without a call because the callback was still running.
    """

    def __init__(
        self,
        period: float,
        callback: Callable[[], Awaitable[None] | None],
        clock: Clock,
        on_failure: Callable[[BaseException], None],
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_timer` instead."""
        self.period = period
        self.skipped = 0
        self._callback = callback
        self._clock = clock
        self._on_failure = on_failure
        self._cancelled = False
        self._scope: anyio.CancelScope | None = None

    @property
    def period(self) -> float:
        """Seconds between two calls, above 0; a change takes effect after the next call."""
        return self._period

    @period.setter
    def period(self, seconds: float) -> None:
        if not seconds > 0:
            raise UsageError(f"a timer's period is in seconds and above 0, got {seconds}")
        self._period = seconds

    @property
    def is_canceled(self) -> bool:
        """True if :meth:`cancel` was called."""
        return self._cancelled

    def cancel(self) -> None:
        """Stop for good; a running callback finishes. Idempotent."""
        self._cancelled = True
        if self._scope is not None:
            self._scope.cancel()

    async def run(self) -> None:
        """Call the callback until cancelled; failures do not end the timer."""
        task = asyncio.current_task()
        due = self._clock.monotonic() + self.period
        while not self._cancelled:
            with anyio.CancelScope() as self._scope:
                await anyio.sleep(max(0.0, due - self._clock.monotonic()))
            self._scope = None
            if self._cancelled:
                return
            CURRENT_CAUSE.set(self)
            try:
                result = self._callback()
                if result is not None:
                    await result
            except BaseException as exc:  # every failure but the end of this task
                if is_end_of(task, exc):
                    raise
                self._on_failure(exc)
            late = max(0.0, self._clock.monotonic() - due)
            missed = int(late // self.period)
            self.skipped += missed
            due += (missed + 1) * self.period
