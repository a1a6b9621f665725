"""An event that happens again and again."""

from __future__ import annotations

from typing import final

import anyio

__all__ = ["PulseEvent"]


@final
class PulseEvent:
    """Wakes everybody who waits at the moment it rings; remembers nothing."""

    def __init__(self) -> None:
        self._next = anyio.Event()

    def ring(self) -> None:
        """Wake all who wait."""
        self._next.set()
        self._next = anyio.Event()

    async def wait(self) -> None:
        """Wait for the next ring."""
        await self._next.wait()
