"""How long tests wait for sockets, threads and other programs."""

from collections.abc import Callable
from typing import Final

import anyio

PATIENCE: Final = 60.0
"""Seconds for what mostly takes milliseconds: only what is broken takes as long, on however slow or busy a machine."""


async def until(is_so: Callable[[], object]) -> None:
    """Wait for something of which no event tells, as another process or a thread does it."""
    with anyio.fail_after(PATIENCE):
        while not is_so():  # noqa: ASYNC110 - no event tells it
            await anyio.sleep(0.02)
