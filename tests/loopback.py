"""One test at a time on loopback's multicast, where devices of the real service types hear all tests of the machine."""

from __future__ import annotations

import fcntl
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio.to_thread

__all__ = ["alone_on_loopback"]


@asynccontextmanager
async def alone_on_loopback() -> AsyncIterator[None]:
    """Wait until no other test is inside such a block, also in another process."""
    with Path(tempfile.gettempdir(), "homebot-tests-loopback.lock").open("w") as file:
        await anyio.to_thread.run_sync(fcntl.flock, file, fcntl.LOCK_EX, abandon_on_cancel=True)
        yield
