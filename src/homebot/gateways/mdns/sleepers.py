"""Sleeping devices: they leave the network, stay listed, and come back."""

from __future__ import annotations

from collections.abc import Callable

import anyio

from homebot.clock import Clock
from homebot.timer_queue import TimerQueue

__all__ = ["MAX_ASLEEP", "Sleepers"]

MAX_ASLEEP = 100
"""Sleeping devices that stay listed; if there are more, the one that has slept longest is removed."""


class Sleepers:
    """The sleeping devices, each until it is back or has slept for too long.

    Args:
        clock: The clock.
        longest: Seconds after which a device that did not come back is removed.
        remove: Called with the name of such a device and the reason as text.
    """

    def __init__(self, clock: Clock, longest: float, remove: Callable[[str, str], None]) -> None:
        self._clock = clock
        self._longest = longest
        self._remove = remove
        self._until: TimerQueue[str, None] = TimerQueue()
        self._names: dict[str, None] = {}
        self._changed = anyio.Event()

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def add(self, name: str) -> None:
        """Add a device that fell asleep; one that sleeps already keeps its deadline."""
        if name in self._names:
            return
        self._names[name] = None
        self._until.set(name, self._clock.monotonic() + self._longest, None)
        self._changed.set()
        if len(self._names) > MAX_ASLEEP:
            self._end(next(iter(self._names)), f"more than {MAX_ASLEEP} devices are asleep")

    def discard(self, name: str) -> None:
        """Drop a device that is awake or gone; does nothing if it does not sleep."""
        self._names.pop(name, None)
        self._until.discard(name)

    async def run(self) -> None:
        """Remove devices that have slept for too long, until cancelled."""
        while True:
            self._changed = anyio.Event()
            now = self._clock.monotonic()
            while (due := self._until.pop(now)) is not None:
                self._end(due[0], f"it did not come back from sleep within {self._longest:g} s")
            next_one = self._until.next()
            with anyio.move_on_after(None if next_one is None else next_one - now):
                await self._changed.wait()

    def _end(self, name: str, why: str) -> None:
        self.discard(name)
        self._remove(name, why)
