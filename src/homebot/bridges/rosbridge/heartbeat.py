"""Pings to a client for as long as something of it must end soon after it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import final

import anyio
import anyio.lowlevel

__all__ = ["Heartbeat"]


@final
class Heartbeat:
    """Watch over a client that owns goals or leases. A socket that closes is seen at once, a lost radio link only so.

    Args:
        ping: Returns when the client has answered.
        interval: Seconds between two pings.
        timeout: Seconds that the client has to answer.
        is_excused: Returns whether the client gave a sign of life since the last call, or is not being read from.
    """

    def __init__(
        self,
        ping: Callable[[], Awaitable[None]],
        interval: float,
        timeout: float,
        is_excused: Callable[[], bool],
    ) -> None:
        self._ping = ping
        self._interval = interval
        self._timeout = timeout
        self._is_excused = is_excused
        self._is_due = anyio.Event()

    def start(self) -> None:
        """Begin to ping; the client owns something."""
        self._is_due.set()

    async def run(self, is_needed: Callable[[], bool]) -> None:
        """Return when the client has vanished while *is_needed* returned that it owns something."""
        while True:
            while not is_needed():
                self._is_due = anyio.Event()
                await self._is_due.wait()
            self._is_excused()
            with anyio.move_on_after(self._timeout) as limit:
                await self._ping()
            if limit.cancelled_caught and is_needed():
                await anyio.lowlevel.checkpoint()  # the answer may have come while the process was busy
                if not self._is_excused():
                    return
            await anyio.sleep(self._interval)
