"""A bounded queue of advertisements without repetitions, and the error of a missing adapter."""

from collections import deque
from dataclasses import dataclass, field

import anyio

from homebot.clock import Clock
from homebot.conventions.bluetooth.broadcast import Advertisement
from homebot.errors import LinkError
from homebot.support.bounded_map import BoundedMap

EVERY = 1.0
"""Seconds between two identical advertisements of a device."""

MAX_WAITING = 1000
MAX_ADDRESSES = 2000


class BluetoothUnavailableError(LinkError):
    """There is no Bluetooth adapter, it is turned off, or the Bluetooth service is not running."""


@dataclass(slots=True)
class Intake:
    """A queue of at most 1,000 advertisements; if it is full, the oldest is dropped.

    Attributes:
        dropped: Number of dropped ones.
        heard_at: The time of the last one that the adapter of this computer heard.
    """

    clock: Clock
    dropped: int = 0
    heard_at: float = float("-inf")
    _waiting: deque[Advertisement] = field(default_factory=deque)
    _last: BoundedMap[str, tuple[float, Advertisement]] = field(default_factory=lambda: BoundedMap(MAX_ADDRESSES))
    _some_wait: anyio.Event = field(default_factory=anyio.Event)

    def put(self, advertisement: Advertisement) -> None:
        """Add an advertisement; never blocks."""
        now = self.clock.monotonic()
        address = advertisement.address
        last = self._last.pop(address, None)
        if last is not None and now - last[0] < EVERY and last[1].says_the_same(advertisement):
            self._last[address] = last
            return
        self._last[address] = now, advertisement
        if len(self._waiting) >= MAX_WAITING:
            self._waiting.popleft()
            self.dropped += 1
        self._waiting.append(advertisement)
        self._some_wait.set()

    async def next(self) -> Advertisement:
        """Return the oldest advertisement; waits for one."""
        while not self._waiting:
            self._some_wait = anyio.Event()
            await self._some_wait.wait()
        return self._waiting.popleft()
