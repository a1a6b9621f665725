"""Commands and events over the WebSocket of a Matter server.

Frames are taken in the order in which they come, so that no event overtakes the list of nodes that it changes.

Source: as :mod:`homebot.gateways.matter.server_messages`.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Final

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

if TYPE_CHECKING:
    from homebot.gateways.http_streams import WebSocket

__all__ = ["MatterServerLink"]

GREETS_WITHIN: Final = 10.0
LISTS_WITHIN: Final = 120.0
ANSWERS_WITHIN: Final = 30.0
"""All in seconds; the server asks a sleepy device several times."""


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
        socket: WebSocket,
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
        self._listing = anyio.CancelScope()

    async def run(self) -> None:
        """Follow the server until the link is lost.

        Raises:
            LinkError: It is lost, or the server does not answer.
            RefusedError: The server does not list its nodes.
            WireError: It is not a Matter server of a known version, or sent too many invalid frames.
        """
        try:
            with anyio.fail_after(GREETS_WITHIN):
                await self._greet()
            with anyio.fail_after(LISTS_WITHIN) as self._listing:
                await self._socket.receive_all(self._on_frame, self._on_invalid)
        except TimeoutError:
            raise LinkError("the Matter server is too slow: it did not greet, or list its nodes, in time") from None
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
        frame = await _parsed(await self._socket.receive())
        if not isinstance(frame, ServerInfo):
            raise WireError("the server at this address is not a Matter server")
        frame.check()
        self.has_bluetooth, self.fabric = frame.has_bluetooth, frame.fabric
        self._listening_id = self._calls.new_id()
        await self._socket.send(command_frame(self._listening_id, "start_listening", {}))

    async def _on_frame(self, payload: bytes) -> None:
        frame = await _parsed(payload)
        if isinstance(frame, MatterEvent):
            await self._on_event(frame, payload)
        elif isinstance(frame, ServerAnswer) and frame.message_id == self._listening_id:
            if frame.error_code is not None:
                raise error_of("the list of nodes", frame)
            await self._on_nodes(frame.result)
            self._listing.deadline = math.inf
        elif isinstance(frame, ServerAnswer):
            await self._calls.resolve(frame.message_id, frame)  # one without a waiting caller came too late


async def _parsed(message: str | bytes) -> ServerFrame:
    """Return the message in a frame; other tasks run while a long one is parsed."""
    payload = message.encode(errors="replace") if isinstance(message, str) else message
    return read_frame(await parse_long_json(payload, MAX_FRAME_BYTES))
