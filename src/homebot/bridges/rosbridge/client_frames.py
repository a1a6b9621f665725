"""Text frames of a client, until it leaves."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import suppress

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

__all__ = ["client_frames"]


async def client_frames(connection: ServerConnection) -> AsyncIterator[str]:
    """Yield the frames of a client until it leaves; a binary one ends the connection, unless it holds JSON.

    The original server takes those too, and websocket-sharp, which ROS# uses, sends bytes in no other way.
    """
    try:
        async for frame in connection:
            text = frame if isinstance(frame, str) else _json_object(frame)
            if text is None:
                await connection.close(CloseCode.UNSUPPORTED_DATA, "the rosbridge server accepts only JSON in UTF-8")
                return
            yield text
    except ConnectionClosed:
        return


def _json_object(frame: bytes) -> str | None:
    """Return the text of a binary frame; None where it cannot be that of a JSON object."""
    with suppress(UnicodeDecodeError):
        return frame.decode() if frame.lstrip()[:1] == b"{" else None
    return None
