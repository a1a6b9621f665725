"""The few connections that an adapter can hold at once, and the queue of devices that want one."""

from __future__ import annotations

from collections.abc import Callable

import anyio

__all__ = ["ConnectionSlots"]


class ConnectionSlots:
    """Hands out a fixed number of connections: to devices with a command first, then in the order of asking.

    One is opened at a time, since adapters refuse a second attempt while the first is under way.

    Args:
        count: Connections that may exist at once.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._taken: set[str] = set()
        self._opening = ""
        self._urgent: set[str] = set()
        self._waiting: dict[str, Callable[[], bool]] = {}
        self._changed = anyio.Event()

    def is_full_for(self, key: str) -> bool:
        """Return whether a device has no slot and none is free."""
        return key not in self._taken and len(self._taken) >= self._count

    @property
    def is_wanted(self) -> bool:
        """True if a device that is in range waits for a slot."""
        return any(self._is_ready(key) for key in self._waiting)

    async def take(self, key: str, is_in_range: Callable[[], bool]) -> None:
        """Wait for a slot, and until no other device is being connected; then call :meth:`opened` or :meth:`release`.

        A device that is out of range waits without holding up others: an attempt to connect to it would only time out.
        One with a command is tried nevertheless.

        Args:
            key: The device.
            is_in_range: Returns whether it was heard lately; call :meth:`notify` when that becomes true.
        """
        self._waiting[key] = is_in_range
        try:
            while self._next() != key:
                await self._changed.wait()
            self._taken.add(key)
            self._opening = key
        finally:
            del self._waiting[key]

    def opened(self, key: str) -> None:
        """Let the next device be connected: this one is."""
        if self._opening == key:
            self._opening = ""
        self.notify()

    def release(self, key: str) -> None:
        """Free the slot of a device."""
        self._taken.discard(key)
        self.opened(key)

    def prefer(self, key: str) -> None:
        """Serve a device before all others, as it has a command."""
        self._urgent.add(key)
        self.notify()

    def unprefer(self, key: str) -> None:
        """End what :meth:`prefer` began."""
        self._urgent.discard(key)
        self.notify()

    def notify(self) -> None:
        """Wake all that wait, since something has changed."""
        self._changed.set()
        self._changed = anyio.Event()

    async def changed(self) -> None:
        """Wait for the next :meth:`notify`."""
        await self._changed.wait()

    def _is_ready(self, key: str) -> bool:
        return key in self._urgent or self._waiting[key]()

    def _next(self) -> str | None:
        """Return the device that gets the next slot; None if there is none to give or nobody to take it."""
        if self._opening or len(self._taken) >= self._count:
            return None
        ready = [key for key in self._waiting if self._is_ready(key)]
        return next((key for key in ready if key in self._urgent), ready[0] if ready else None)
