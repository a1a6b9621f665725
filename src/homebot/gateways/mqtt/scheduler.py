"""Does what is planned when its time has come."""

from __future__ import annotations

import math
from collections.abc import Hashable

import anyio
import anyio.lowlevel

from homebot.clock import Clock
from homebot.gateways.mqtt.timer_queue import Callback, TimerQueue

__all__ = ["Scheduler"]

_TURN = 100
"""Deeds done before others get their turn."""


class Scheduler:
    """An agenda that is kept by one task, in the clock's own time.

    Args:
        clock: The clock.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._agenda = TimerQueue()
        self._wakes_at = math.inf
        self._earlier = anyio.Event()

    def plan(self, name: Hashable, after: float, deed: Callback) -> bool:
        """Plan *deed* in *after* seconds, in place of what was planned under *name*; False when there is no room."""
        at = self._clock.monotonic() + after
        is_planned = self._agenda.plan(name, at, deed)
        if is_planned and at < self._wakes_at:
            self._earlier.set()
        return is_planned

    def drop(self, name: Hashable) -> None:
        """Plan nothing under *name* any more."""
        self._agenda.drop(name)

    async def run(self) -> None:
        """Keep the agenda until cancelled."""
        while True:
            self._earlier = anyio.Event()
            next_at = self._agenda.next()
            self._wakes_at = math.inf if next_at is None else next_at
            with anyio.move_on_after(max(0.0, self._wakes_at - self._clock.monotonic())):
                await self._earlier.wait()
            done = 0
            while (deed := self._agenda.pop(self._clock.monotonic())) is not None:
                deed()
                done += 1
                if done % _TURN == 0:
                    await anyio.lowlevel.checkpoint()
