"""The end of listening of a server."""

import asyncio
import socket
from collections.abc import Iterable

from anyio.lowlevel import cancel_shielded_checkpoint


async def stop_accepting(sockets: Iterable[socket.socket]) -> None:
    """Accept no more connections on *sockets*; those that were accepted reach their protocol, to be closed by it.

    A server that is closed at once leaves a connection open whose transport is not built yet (CPython 3.11,
    ``asyncio.base_events.Server._attach``).
    """
    loop = asyncio.get_running_loop()
    for listening in sockets:
        loop.remove_reader(listening)
    await cancel_shielded_checkpoint()  # builds the transport
    await cancel_shielded_checkpoint()  # connects it to its protocol
