"""Commands and events over the WebSocket of a Matter server.

A server greets with its version, answers each command with its ``message_id``, and sends events of its own. Frames are
taken in the order in which they come, so that no event overtakes the list of nodes that it changes.

Source: python-matter-server 8.1, ``docs/websockets_api.md`` and ``common/models.py`` (schema version 11); the server of
matter.js follows the same.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Final, TypeAlias

import anyio

from homebot.conventions.payload import as_fields, clean_text, compact_json, shown
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.pending_calls import PendingCalls
from homebot.support.numbers import whole_number

if TYPE_CHECKING:
    from homebot.gateways.http_streams import WebSocket

MAX_FRAME_BYTES: Final = 32 * 1024 * 1024
"""Longest frame: the answer to ``start_listening`` has every attribute of every node, some 50 kB for each node."""

SCHEMA: Final = 11
"""The newest version that this module follows."""

OLDEST_SCHEMA: Final = 5

GREETS_WITHIN: Final = 10.0
LISTS_WITHIN: Final = 120.0
ANSWERS_WITHIN: Final = 30.0
"""All in seconds; the server asks a sleepy device several times."""

_NODE_NOT_READY, _NODE_NOT_RESOLVING, _SDK_STACK = 3, 4, 7
_TIMEOUTS = ("0x00000032", "timeout", "timed out")
"""Texts in the details of an error when the device did not answer, for which there is no error code."""

_Fields: TypeAlias = Mapping[str, object]

OnEvent: TypeAlias = Callable[[str, object, bytes], Awaitable[None]]
"""Takes the name of an event, such as ``attribute_updated``, its data, and the frame that it came in."""


class MatterServerLink:
    """A connection to a Matter server.

    Args:
        on_nodes: Takes the list of all nodes, before any later event.
        on_invalid: Takes each invalid frame, and the reason.

    Attributes:
        fabric: The compressed ID of the server's fabric, 16 digits; empty if it is not known.
        has_bluetooth: Whether the server can commission devices over Bluetooth, as its greeting says.
    """

    def __init__(
        self,
        socket: WebSocket,
        on_nodes: Callable[[object], Awaitable[None]],
        on_event: OnEvent,
        on_invalid: Callable[[bytes, str], None],
    ) -> None:
        self.fabric = ""
        self.has_bluetooth = False
        self._socket = socket
        self._on_nodes = on_nodes
        self._on_event = on_event
        self._on_invalid = on_invalid
        self._calls = PendingCalls[_Fields]("the Matter server")
        self._listening_id = self._calls.new_id()
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
                greeting = await _parse(await self._socket.receive())
                check_greeting(greeting)
                fabric = greeting.get("compressed_fabric_id")
                self.fabric = f"{fabric:016X}" if type(fabric) is int and 0 < fabric < 1 << 64 else ""
                self.has_bluetooth = greeting.get("bluetooth_enabled") is True
                await self._send(self._listening_id, "start_listening", {})
            with anyio.fail_after(LISTS_WITHIN) as self._listing:
                await self._socket.receive_all(self._on_frame, self._on_invalid)
        except TimeoutError:
            raise LinkError("the Matter server is too slow: it did not greet, or list its nodes, in time") from None
        finally:
            self._calls.end()

    async def call(
        self, what: str, command: str, args: _Fields, *, is_secret: bool = False, within: float = ANSWERS_WITHIN
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
            await self._send(message_id, command, args)

        return result_of(what, await self._calls.call(what, send, within), is_secret=is_secret)

    async def _send(self, message_id: str, command: str, args: _Fields) -> None:
        await self._socket.send(compact_json({"message_id": message_id, "command": command, "args": dict(args)}))

    async def _on_frame(self, payload: bytes) -> None:
        frame = await _parse(payload)
        event, message_id = frame.get("event"), frame.get("message_id")
        if isinstance(event, str):
            await self._on_event(event, frame.get("data"), payload)
        elif message_id == self._listening_id:
            await self._on_nodes(result_of("the list of nodes", frame))
            self._listing.deadline = math.inf
        elif isinstance(message_id, str):
            await self._calls.resolve(message_id, frame)  # one without a waiting caller came too late
        else:
            raise WireError("a message is neither an event nor an answer")


async def _parse(message: str | bytes) -> _Fields:
    """Return the object in a frame; other tasks run while a long one is parsed."""
    payload = message.encode(errors="replace") if isinstance(message, str) else message
    frame = await parse_long_json(payload, MAX_FRAME_BYTES)
    if not isinstance(frame, dict):
        raise WireError(f"{shown(frame)} is not an object")
    return frame


def check_greeting(greeting: _Fields) -> None:
    """Raise WireError if a server says in its *greeting* that homebot does not understand its messages."""
    schema = whole_number(greeting.get("schema_version"))
    if schema is None or "event" in greeting or "message_id" in greeting:
        raise WireError("the server at this address is not a Matter server")
    if schema < OLDEST_SCHEMA:
        raise WireError(f"the Matter server uses schema version {schema}; homebot needs {OLDEST_SCHEMA} or later")
    if (oldest := whole_number(greeting.get("min_supported_schema_version")) or 0) > SCHEMA:
        raise WireError(f"the Matter server needs schema version {oldest} or later; homebot knows {SCHEMA}")


def result_of(what: str, answer: _Fields, *, is_secret: bool = False) -> object:
    """Return the result in an *answer*.

    Args:
        is_secret: Whether the command had a code in it; the details, which may repeat it, are not shown then.

    Raises:
        LinkError: The device did not answer the server.
        RefusedError: The answer has another error code.
    """
    if "error_code" not in answer:
        return answer.get("result")
    code, text = whole_number(answer["error_code"]), answer.get("details")
    details = text[:2_000] if isinstance(text, str) else ""
    reason = ("" if is_secret else clean_text(details)) or f"the Matter server answered with error {code}"
    is_timeout = any(word in details.casefold() for word in _TIMEOUTS)
    if code in {_NODE_NOT_READY, _NODE_NOT_RESOLVING, _SDK_STACK} or is_timeout:
        raise LinkError(f"{what}: {reason}")
    raise RefusedError(what, reason, code)


def check_result(what: str, result: object) -> None:
    """Raise RefusedError if the *result* of a command has a status of failure, as writes and operations may."""
    fields = as_fields(result)
    operation = as_fields(fields.get("commandResponseState"))
    writes = [as_fields(write).get("Status") for write in result] if isinstance(result, list) else []
    for status in (*writes, fields.get("status"), operation.get("errorStateID", operation.get("errorStateId"))):
        if type(status) is int and status != 0:
            raise RefusedError(what, f"the device answered with the status 0x{status:02x}", status)
