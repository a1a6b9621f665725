"""Timers of a broker that runs on an event loop: its deadlines, and chores every few seconds."""

from __future__ import annotations

import asyncio
from typing import Final, final

from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.stats import LossReport

__all__ = ["DeadlineTimer", "Housekeeping"]


@final
class DeadlineTimer:
    """One timer of the running event loop, set to the earliest deadline; works from :meth:`start` on."""

    def __init__(self, state: BrokerState) -> None:
        self._state = state
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Do overdue work and wait for the next."""
        self._state.deadlines.wake = self._wake_at
        self.tick()

    def tick(self) -> None:
        """Do the work due by the broker's clock."""
        state = self._state
        try:
            state.deadlines.run(state.clock.monotonic())
        finally:
            earliest = state.deadlines.earliest
            if earliest is not None:
                self._wake_at(earliest)

    def stop(self) -> None:
        """Run nothing more."""
        self._state.deadlines.wake = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _wake_at(self, when: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        delay = max(0.0, when - self._state.clock.monotonic())
        self._timer = asyncio.get_running_loop().call_later(delay, self.tick)


_EVERY: Final = 10.0


@final
class Housekeeping:
    """A timer of the running loop, from :meth:`start` to :meth:`stop`."""

    def __init__(self, state: BrokerState) -> None:
        self._state = state
        self._losses = LossReport(state.counters)
        self._timer: asyncio.TimerHandle | None = None

    @property
    def losses(self) -> str:
        """Losses of the last ten minutes, as text."""
        return self._losses.lately

    def start(self) -> None:
        """Begin."""
        self._timer = asyncio.get_running_loop().call_later(_EVERY, self._run)

    def stop(self) -> None:
        """End."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _run(self) -> None:
        if lost := self._losses.take():
            self._state.warn("broker.dropped", f"the broker dropped {lost} in the last {_EVERY:g} s")
        self.start()
