"""A clock that a test can hold, so that work is counted and not the time that a slow machine takes for it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["HeldClock"]


class HeldClock:
    """The time of the running event loop, which stands still while it is held; timers of the loop go on."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._epoch = time.time() - self._loop.time()
        self._missed = 0.0
        self._held_at: float | None = None

    def monotonic(self) -> float:
        """Return seconds since an arbitrary start."""
        return self._loop.time() - self._missed if self._held_at is None else self._held_at

    def now(self) -> float:
        """Return seconds since the Unix epoch."""
        return self._epoch + self.monotonic()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Let it stand still inside the block."""
        self._held_at = self.monotonic()
        try:
            yield
        finally:
            self._missed = self._loop.time() - self._held_at
            self._held_at = None
