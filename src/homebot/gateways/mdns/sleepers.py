"""Devices that sleep: they leave the network and come back, and stay listed meanwhile."""

from __future__ import annotations

from collections.abc import Callable

import anyio

from homebot.clock import Clock
from homebot.timer_queue import TimerQueue

__all__ = ["MAX_ASLEEP", "Sleepers"]

MAX_ASLEEP = 100
"""Devices that are listed while they sleep; of more, the one that has slept longest is taken out."""


class Sleepers:
    """The devices that are asleep, each until it is heard again, or has slept for too long.

    Args:
        clock: The clock.
        longest: Seconds after which a device that was not heard again is taken out.
        take_out: Called with its name then, and with the reason as text.
    """

    def __init__(self, clock: Clock, longest: float, take_out: Callable[[str, str], None]) -> None:
        self._clock = clock
        self._longest = longest
        self._take_out = take_out
        self._until: TimerQueue[str, None] = TimerQueue()
        self._names: dict[str, None] = {}
        self._changed = anyio.Event()

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def add(self, name: str) -> None:
        """Note that a device fell asleep; one that is asleep already has its time from before."""
        if name in self._names:
            return
        self._names[name] = None
        self._until.set(name, self._clock.monotonic() + self._longest, None)
        self._changed.set()
        if len(self._names) > MAX_ASLEEP:
            self._end(next(iter(self._names)), f"more than {MAX_ASLEEP} devices are asleep")

    def discard(self, name: str) -> None:
        """Note that a device is awake, or gone; one that is not asleep is fine."""
        self._names.pop(name, None)
        self._until.discard(name)

    async def run(self) -> None:
        """Take out what has slept for too long, until cancelled."""
        while True:
            self._changed = anyio.Event()
            now = self._clock.monotonic()
            while (due := self._until.pop(now)) is not None:
                self._end(due[0], f"it was not heard for {self._longest:g} s, which is too long for sleep")
            next_one = self._until.next()
            with anyio.move_on_after(None if next_one is None else next_one - now):
                await self._changed.wait()

    def _end(self, name: str, why: str) -> None:
        self.discard(name)
        self._take_out(name, why)
