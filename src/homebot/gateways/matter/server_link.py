"""Commands and events over the WebSocket of a Matter server.

Frames are taken in the order in which they come, so that no event overtakes the list of nodes that it changes.

Source: as :mod:`homebot.gateways.matter.server_messages`.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Final, Protocol

import anyio

from homebot.errors import LinkError, WireError
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.matter.server_messages import (
    MAX_FRAME_BYTES,
    MatterEvent,
    ServerAnswer,
    ServerFrame,
    ServerInfo,
    command_frame,
    error_of,
    read_frame,
)
from homebot.gateways.pending_calls import PendingCalls

__all__ = ["MatterServerLink", "ServerSocket"]

GREETS_WITHIN: Final = 10.0
LISTS_WITHIN: Final = 120.0
ANSWERS_WITHIN: Final = 30.0
"""All in seconds; the server asks a sleepy device several times."""

MOST_INVALID: Final = 100
"""Invalid frames in a row after which the connection is closed."""


class ServerSocket(Protocol):
    """An open WebSocket."""

    async def send(self, message: str | bytes) -> None:
        """Send a message."""

    async def receive(self) -> str | bytes:
        """Wait for a message."""


class MatterServerLink:
    """A connection to a Matter server.

    Args:
        on_nodes: Takes the list of all nodes, before any later event.
        on_event: Takes an event, and the frame that it came in.
        on_invalid: Takes each invalid frame, and the reason.

    Attributes:
        fabric: The compressed ID of the server's fabric; empty if it is not known.
        has_bluetooth: Whether the server can commission devices over Bluetooth, as its greeting says.
    """

    def __init__(
        self,
        socket: ServerSocket,
        on_nodes: Callable[[object], Awaitable[None]],
        on_event: Callable[[MatterEvent, bytes], Awaitable[None]],
        on_invalid: Callable[[bytes, str], None],
    ) -> None:
        self.fabric = ""
        self.has_bluetooth = False
        self._socket = socket
        self._on_nodes = on_nodes
        self._on_event = on_event
        self._on_invalid = on_invalid
        self._calls = PendingCalls[ServerAnswer]("the Matter server")
        self._listening_id = ""

    async def run(self) -> None:
        """Follow the server until the link is lost.

        Raises:
            LinkError: It is lost, or the server does not answer.
            RefusedError: The server does not list its nodes.
            WireError: It is not a Matter server of a known version, or sent too many invalid frames.
        """
        try:
            await self._greet()
            with _limit(LISTS_WITHIN, "it did not list its nodes"):
                while not await self._handle_next():
                    pass
            while True:
                await self._handle_next()
        finally:
            self._calls.end()

    async def call(
        self,
        what: str,
        command: str,
        args: Mapping[str, object],
        *,
        is_secret: bool = False,
        within: float = ANSWERS_WITHIN,
    ) -> object:
        """Send the server a command, and return the result.

        Args:
            is_secret: Whether there is a code in them, so that errors show no details.
            within: Seconds to wait for the answer.

        Raises:
            LinkError: The link is lost, there was no answer in time, or a device cannot be reached.
            RefusedError: The server or the device refuses.
        """

        async def send(message_id: str) -> None:
            await self._socket.send(command_frame(message_id, command, args))

        answer = await self._calls.call(what, send, within)
        if answer.error_code is not None:
            raise error_of(what, answer, is_secret=is_secret)
        return answer.result

    async def _greet(self) -> None:
        with _limit(GREETS_WITHIN, "it sent no greeting"):
            frame = await _parsed(_as_bytes(await self._socket.receive()))
        if not isinstance(frame, ServerInfo):
            raise WireError("the server at this address is not a Matter server")
        frame.check()
        self.has_bluetooth, self.fabric = frame.has_bluetooth, frame.fabric
        self._listening_id = self._calls.new_id()
        await self._socket.send(command_frame(self._listening_id, "start_listening", {}))

    async def _handle_next(self) -> bool:
        """Handle the next frame; return whether it was the list of nodes."""
        for _ in range(MOST_INVALID):
            payload = _as_bytes(await self._socket.receive())
            try:
                return await self._handle(await _parsed(payload), payload)
            except WireError as exc:
                self._on_invalid(payload, str(exc))
        raise WireError(f"the Matter server sent {MOST_INVALID} invalid frames in a row")

    async def _handle(self, frame: ServerFrame, payload: bytes) -> bool:
        if isinstance(frame, MatterEvent):
            await self._on_event(frame, payload)
        elif isinstance(frame, ServerAnswer):
            if frame.message_id == self._listening_id:
                if frame.error_code is not None:
                    raise error_of("the list of nodes", frame)
                await self._on_nodes(frame.result)
                return True
            await self._calls.resolve(frame.message_id, frame)  # one without a waiting caller came too late
        return False


def _as_bytes(message: str | bytes) -> bytes:
    return message.encode(errors="replace") if isinstance(message, str) else message


async def _parsed(payload: bytes) -> ServerFrame:
    """Return the message in a frame; other tasks run while a long one is parsed."""
    return read_frame(await parse_long_json(payload, MAX_FRAME_BYTES))


@contextmanager
def _limit(seconds: float, problem: str) -> Iterator[None]:
    """Raise ``LinkError`` if the block takes longer."""
    try:
        with anyio.fail_after(seconds):
            yield
    except TimeoutError:
        raise LinkError(f"the Matter server is too slow: {problem} within {seconds:g} s") from None
