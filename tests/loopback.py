"""One test at a time on loopback's multicast, where devices of the real service types hear all tests of the machine."""

import fcntl
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio.to_thread


@asynccontextmanager
async def alone_on_loopback() -> AsyncIterator[None]:
    """Wait until no other test is inside such a block, also in another process, of whichever user.

    The lock is on the root folder: a file in /tmp could only be opened by the user whose tests came first.
    """
    opened = os.open("/", os.O_RDONLY)
    try:
        await anyio.to_thread.run_sync(fcntl.flock, opened, fcntl.LOCK_EX, abandon_on_cancel=True)
        yield
    finally:
        os.close(opened)
