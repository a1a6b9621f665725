"""The WebSocket to Home Assistant; the one file of the gateway that knows websockets."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import anyio.lowlevel
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, WebSocketException

from homebot.errors import LinkError
from homebot.support.connect_errors import connect_problem

__all__ = ["HomeAssistantSocket", "opened"]

MAX_FRAME_BYTES = 64 * 1024 * 1024
"""Longest frame: all states of 10,000 entities, some 1 kB each, and much more for those with long attributes."""

OPENS_WITHIN = 10.0
CLOSES_WITHIN = 1.0
ALIVE_WITHIN = 20.0
"""In seconds; a peer that does not answer a ping for this long is lost."""


class HomeAssistantSocket:
    """An open WebSocket; everything raises :class:`LinkError` once it is lost."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection

    async def send(self, message: str) -> None:
        """Send a message."""
        try:
            await self._connection.send(message)
        except ConnectionClosed as exc:
            raise LinkError("the connection to Home Assistant was lost") from exc

    async def receive(self) -> bytes:
        """Wait for a message."""
        try:
            message = await self._connection.recv()
        except ConnectionClosed as exc:
            raise LinkError("Home Assistant closed the connection") from exc
        return message.encode() if isinstance(message, str) else message


@asynccontextmanager
async def opened(url: str) -> AsyncIterator[HomeAssistantSocket]:
    """Open the WebSocket at *url* inside the block.

    Raises:
        LinkError: It cannot be opened now.
    """
    connecting = connect(
        url,
        proxy=None,
        compression=None,
        open_timeout=OPENS_WITHIN,
        close_timeout=CLOSES_WITHIN,
        ping_interval=ALIVE_WITHIN,
        ping_timeout=ALIVE_WITHIN,
        max_size=MAX_FRAME_BYTES,
    )
    try:
        connection = await connecting
    except TimeoutError as exc:
        raise LinkError(f"{url} did not answer within {OPENS_WITHIN:g} s") from exc
    except (OSError, InvalidHandshake, WebSocketException) as exc:
        problem = connect_problem(exc) if isinstance(exc, OSError) else exc
        raise LinkError(f"{url} cannot be opened: {problem}") from exc
    try:
        yield HomeAssistantSocket(connection)
    finally:
        with anyio.move_on_after(CLOSES_WITHIN, shield=True):
            await connection.close()
            await anyio.lowlevel.cancel_shielded_checkpoint()  # its own tasks end after it
