"""Sleeping devices: they leave the network, stay listed, and come back."""

from __future__ import annotations

from collections.abc import Callable

import anyio

from homebot.clock import Clock

__all__ = ["MAX_ASLEEP", "Sleepers"]

MAX_ASLEEP = 100
"""Sleeping devices that stay listed; if there are more, the one that has slept longest is removed."""


class Sleepers:
    """The sleeping devices, each until it is back or has slept for too long.

    Args:
        longest: Seconds after which a device that did not come back is removed.
        remove: Called with the name of such a device and the reason as text.
    """

    def __init__(self, clock: Clock, longest: float, remove: Callable[[str, str], None]) -> None:
        self._clock = clock
        self._longest = longest
        self._remove = remove
        self._until: dict[str, float] = {}  # the first ends first: all may sleep equally long
        self._changed = anyio.Event()

    def __contains__(self, name: object) -> bool:
        return name in self._until

    def add(self, name: str) -> None:
        """Add a device that fell asleep; one that sleeps already keeps its deadline."""
        if name in self._until:
            return
        self._until[name] = self._clock.monotonic() + self._longest
        self._changed.set()
        if len(self._until) > MAX_ASLEEP:
            self._end(next(iter(self._until)), f"more than {MAX_ASLEEP} devices are asleep")

    def discard(self, name: str) -> None:
        """Drop a device that is awake or gone; does nothing if it does not sleep."""
        self._until.pop(name, None)

    async def run(self) -> None:
        """Remove devices that have slept for too long, until cancelled."""
        while True:
            self._changed = anyio.Event()
            now = self._clock.monotonic()
            for name in [one for one, until in self._until.items() if until <= now]:
                self._end(name, f"it did not come back from sleep within {self._longest:g} s")
            next_end = next(iter(self._until.values()), None)
            with anyio.move_on_after(None if next_end is None else next_end - now):
                await self._changed.wait()

    def _end(self, name: str, why: str) -> None:
        self.discard(name)
        self._remove(name, why)
