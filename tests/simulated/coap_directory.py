"""A resource directory (RFC 9176) in which simulated CoAP devices register: aiocoap's own."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import aiocoap
import anyio
from aiocoap.cli.rd import StandaloneResourceDirectory


@asynccontextmanager
async def served_directory(host: str, port: int) -> AsyncIterator[None]:
    """Serve an empty directory at *host* and *port* inside the block."""
    context = await aiocoap.Context.create_server_context(None, bind=(host, port), transports=["udp6"])
    context.serversite = StandaloneResourceDirectory(context=context, lwm2m_compat=True)
    try:
        yield
    finally:
        with anyio.CancelScope(shield=True):
            await context.shutdown()
            # The directory leaves the lifetimes of its registrations behind.
            left = [task for task in asyncio.all_tasks() if task.get_name().startswith("RD Timeout")]
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)
