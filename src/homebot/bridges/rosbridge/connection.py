"""A WebSocket connection of the door that reads only as fast as the door answers.

A flood of frames reaches the session, which knows the limits; the library answers pings
and invalid frames by itself, so they are slowed down here. A client that does not read is not read from either:
otherwise the answers to its pings would pile up.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from homebot.bridges.turns import ServerTurns

__all__ = ["DoorConnection", "client_frames", "is_roslibpy"]

_READ = 2048
"""Bytes read at once: of the smallest frames 340, which take the library about 5 ms."""

_MOST_ARRIVING = 64
"""Connections without a request yet; one more ends the oldest."""


class DoorConnection(ServerConnection):
    """A connection that does not hold up the event loop.

    Args:
        turns: When work may be done.
        arriving: The connections without a session, oldest first; this one adds itself.
        arguments: As the library makes connections.
    """

    def __init__(
        self, turns: ServerTurns, arriving: dict[DoorConnection, None], *arguments: Any, **settings: Any
    ) -> None:
        super().__init__(*arguments, **settings)
        self._turns = turns
        self._arriving = arriving
        self._holds: set[str] = set()
        self._is_lost = False
        self._is_heard = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to read."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):  # asyncio has no other way to set it
            transport.max_size = _READ
        # The library pauses reading for reasons of its own, so there is one place that knows them all.
        self.recv_messages.pause = lambda: self._hold("queue")
        self.recv_messages.resume = lambda: self._release("queue")
        self._arriving[self] = None
        if len(self._arriving) > _MOST_ARRIVING:
            oldest = next(iter(self._arriving))
            del self._arriving[oldest]
            oldest.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Handle *data* now or at the next turn; until then nothing more is read."""
        self._is_heard = True
        if self._turns.has_time():
            super().data_received(data)
            return
        self._hold("turn")
        self._turns.defer(lambda: self._receive(data))

    def pause_writing(self) -> None:
        """Stop reading from a client that does not read its answers."""
        super().pause_writing()
        self._hold("writing")

    def resume_writing(self) -> None:
        """Read again: the client takes bytes."""
        super().resume_writing()
        self._release("writing")

    def connection_lost(self, exc: Exception | None) -> None:
        """Discard unsent data."""
        self._is_lost = True
        self._arriving.pop(self, None)
        super().connection_lost(exc)

    def is_excused(self) -> bool:
        """Return whether the client was heard since the last call, or is not being read from: it may say what it likes.

        A client that does not read is no excuse: nor does one that has vanished.
        """
        was_heard, self._is_heard = self._is_heard, False
        return was_heard or not self._holds <= {"writing"}

    def has_arrived(self) -> None:
        """Record that the connection has a session."""
        self._arriving.pop(self, None)

    def _receive(self, data: bytes) -> None:
        if not self._is_lost:
            super().data_received(data)
            self._release("turn")

    def _hold(self, why: str) -> None:
        if not self._holds and not self._is_lost:
            self.transport.pause_reading()
        self._holds.add(why)

    def _release(self, why: str) -> None:
        self._holds.discard(why)
        if not self._holds and not self._is_lost:
            self.transport.resume_reading()


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


def is_roslibpy(connection: ServerConnection) -> bool:
    """Return whether the client is roslibpy, which (to 2.1 at least) reads neither PNG nor ``status`` frames."""
    agent = connection.request.headers.get("User-Agent", "") if connection.request is not None else ""
    return agent.startswith("AutobahnPython/")


def _json_object(frame: bytes) -> str | None:
    """Return the text of a binary frame; None where it cannot be that of a JSON object."""
    with suppress(UnicodeDecodeError):
        return frame.decode() if frame.lstrip()[:1] == b"{" else None
    return None
