"""The few connections that an adapter can hold at once, and the queue of devices that want one."""

from collections.abc import Callable

import anyio


class ConnectionSlots:
    """Hands out a fixed number of connections: to devices with a command first, then in the order of asking.

    One is opened at a time, since adapters refuse a second attempt while the first is under way.

    Args:
        is_in_range: Returns whether a device was heard lately; call :meth:`notify` when that becomes true.
    """

    def __init__(self, count: int, is_in_range: Callable[[str], bool]) -> None:
        self._count = count
        self._is_in_range = is_in_range
        self._taken: set[str] = set()
        self._opening = ""
        self._urgent: set[str] = set()
        self._waiting: dict[str, anyio.Event] = {}
        self._changed = anyio.Event()

    def is_full_for(self, key: str) -> bool:
        """Return whether a device has no slot and none is free."""
        return key not in self._taken and len(self._taken) >= self._count

    @property
    def is_wanted(self) -> bool:
        """True if a device that is in range waits for a slot."""
        return self._next() is not None

    async def acquire(self, key: str) -> None:
        """Wait for a slot, and until no other device is being connected; then call :meth:`opened` or :meth:`release`.

        A device that is out of range waits without holding up others: an attempt to connect to it would only time out.
        One with a command is tried nevertheless.
        """
        granted = self._waiting[key] = anyio.Event()
        self._grant()
        try:
            await granted.wait()
        except anyio.get_cancelled_exc_class():
            if self._waiting.pop(key, None) is None:
                self.release(key)
            raise

    def opened(self, key: str) -> None:
        """Allow the next connection: this device is connected."""
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
        """End the preference that :meth:`prefer` began."""
        self._urgent.discard(key)
        self.notify()

    def notify(self) -> None:
        """Look at the queue again, and wake the tasks that wait for :meth:`changed`."""
        self._grant()
        self._changed.set()
        self._changed = anyio.Event()

    async def changed(self) -> None:
        """Wait for the next :meth:`notify`."""
        await self._changed.wait()

    def _grant(self) -> None:
        if self._opening or len(self._taken) >= self._count:
            return
        key = self._next()
        if key is not None:
            self._taken.add(key)
            self._opening = key
            self._waiting.pop(key).set()

    def _next(self) -> str | None:
        urgent = next((key for key in self._waiting if key in self._urgent), None) if self._urgent else None
        return urgent or next(filter(self._is_in_range, self._waiting), None)
