"""Commands and events over the WebSocket of Home Assistant; the only file of the gateway that uses websockets.

Frames are handled in order; each event waits until the previous one is handled.

Source: Home Assistant core 2024.3, ``components/websocket_api``; https://developers.home-assistant.io/docs/api/websocket
"""

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Final, TypeAlias

import anyio
import anyio.lowlevel
import anyio.to_thread
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, WebSocketException

from homebot.conventions.payload import as_fields, compact_json, shown, text_of
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.pending_calls import PendingCalls
from homebot.integrations.homeassistant.gateway.settings import HomeAssistantGatewaySettings
from homebot.support.connect_errors import connect_problem

MAX_FRAME_BYTES = 64 * 1024 * 1024
"""Longest frame: all states of 10,000 entities, of about 1 kB each, and much more with long attributes."""

MAX_GREETING_BYTES: Final = 64 * 1024
"""Longest frame before the login: anybody may be at this address."""

OPENS_WITHIN = 5.0
CLOSES_WITHIN = 1.0
ALIVE_WITHIN = 20.0
"""In seconds; a peer that does not answer a ping for this long counts as lost."""

GREETS_WITHIN: Final = 5.0
ANSWERS_WITHIN: Final = 30.0
"""In seconds; a service that takes longer, such as for a sleepy device, continues without us."""

MAX_INVALID_MESSAGES: Final = 100
"""Consecutive invalid frames after which the connection is closed."""

OLDEST: Final = (2022, 11)
"""The oldest supported version: with ``subscribe_entities`` and white in kelvin."""

_UNREACHED: Final = frozenset({"timeout"})

OnEvent: TypeAlias = Callable[[Mapping[str, object]], Awaitable[None]]
"""Receives an event of a subscription."""

_Frame: TypeAlias = Mapping[str, object]


class HomeAssistantLink:
    """A connection to Home Assistant over an open WebSocket, made by :func:`connected`."""

    def __init__(self, connection: ClientConnection, on_invalid: Callable[[bytes, str], None]) -> None:
        self._connection = connection
        self._on_invalid = on_invalid
        self._calls = PendingCalls[_Frame]("Home Assistant")
        self._listeners: dict[str, OnEvent] = {}

    async def greet(self, token: str) -> None:
        """Log in with the token; raises the errors of :func:`connected`."""
        try:
            with anyio.fail_after(GREETS_WITHIN):
                await self._expect("auth_required")
                await self._send(compact_json({"type": "auth", "access_token": token}))
                await self._expect("auth_ok")
            for name in ("max_size", "max_message_size"):  # to and from websockets 16
                if hasattr(self._connection.protocol, name):
                    setattr(self._connection.protocol, name, MAX_FRAME_BYTES)
        except TimeoutError:
            raise LinkError(f"Home Assistant did not greet within {GREETS_WITHIN:g} s") from None

    async def read(self) -> None:
        """Handle frames until the link is lost.

        Raises:
            LinkError: It is lost.
            WireError: Home Assistant sent too many invalid frames.
        """
        invalid = 0
        try:
            while invalid < MAX_INVALID_MESSAGES:
                payload = await self._receive()
                try:
                    frame = await self._parse(payload)
                    await self._handle(frame)
                    invalid = 0
                except WireError as exc:
                    self._on_invalid(payload, str(exc))
                    invalid += 1
            raise WireError(f"Home Assistant sent {MAX_INVALID_MESSAGES} invalid frames in a row")
        finally:
            self._calls.end()

    async def call(
        self,
        what: str,
        command: str,
        args: Mapping[str, object] | None = None,
        on_event: OnEvent | None = None,
        within: float = ANSWERS_WITHIN,
    ) -> object:
        """Send a command, and return its result.

        Args:
            what: The action, for errors.
            on_event: Receives the events of a subscription.
            within: Seconds to wait for the answer.

        Raises:
            LinkError: The link is lost, or there was no answer in time.
            RefusedError: Home Assistant refuses.
        """

        async def send(number: str) -> None:
            if on_event is not None:
                self._listeners[number] = on_event
            await self._send(compact_json({"id": int(number), "type": command, **(args or {})}))

        answer = await self._calls.call(what, send, within)
        if answer.get("success") is True:
            return answer.get("result")
        error = as_fields(answer.get("error"))
        reason = text_of(error.get("message"), 200) or text_of(error.get("code")) or "it gave no reason"
        if error.get("code") in _UNREACHED:
            raise LinkError(f"{what}: {reason}")
        raise RefusedError(what, reason)

    async def _send(self, message: str) -> None:
        try:
            await self._connection.send(message)
        except ConnectionClosed as exc:
            raise LinkError("the connection to Home Assistant was lost") from exc

    async def _receive(self) -> bytes:
        try:
            message = await self._connection.recv()
        except ConnectionClosed as exc:
            raise LinkError("Home Assistant closed the connection") from exc
        return message.encode() if isinstance(message, str) else message

    async def _expect(self, kind: str) -> None:
        frame = await self._parse(await self._receive())
        if frame.get("type") == "auth_invalid":
            raise RefusedError("the login to Home Assistant", "the token was revoked, has expired or is another's")
        if frame.get("type") != kind:
            raise WireError("the server at this address is not Home Assistant")
        version = text_of(frame.get("ha_version"), 40)
        numbers = [int(number) if number.isdecimal() else 0 for number in version.split(".")[:2]]
        if tuple(numbers) < OLDEST:
            raise WireError(f"it is Home Assistant {version}; homebot needs {OLDEST[0]}.{OLDEST[1]} or later")

    async def _parse(self, payload: bytes) -> _Frame:
        frame = await parse_long_json(payload, MAX_FRAME_BYTES)
        if not isinstance(frame, dict):
            raise WireError(f"{shown(frame)} is not an object")
        return frame

    async def _handle(self, frame: _Frame) -> None:
        number = frame.get("id")
        if isinstance(number, bool) or not isinstance(number, int):
            raise WireError(f"the id of a message is {shown(number)}, not a number")
        match frame.get("type"):
            case "event":
                event = frame.get("event")
                listener = self._listeners.get(str(number))
                if listener is None or not isinstance(event, dict):
                    raise WireError(f"an event of subscription {number} is {shown(event)}")
                await listener(event)
            case "result":
                await self._calls.resolve(str(number), frame)  # an answer without a waiting caller is late
            case kind:
                raise WireError(f"a message is of type {shown(kind)}, neither result nor event")


@asynccontextmanager
async def connected(
    settings: HomeAssistantGatewaySettings, on_invalid: Callable[[bytes, str], None]
) -> AsyncIterator[HomeAssistantLink]:
    """Keep a connection to Home Assistant inside the block, logged in with the token.

    Args:
        on_invalid: Receives each invalid frame with the reason.

    Raises:
        LinkError: It cannot be reached now.
        RefusedError: It refuses the token; the message gives the remedy.
        UsageError: The token cannot be read.
        WireError: It is not Home Assistant, or the version is too old.
    """
    token = await anyio.to_thread.run_sync(settings.read_token)
    connection = await _open(settings.websocket)
    try:
        link = HomeAssistantLink(connection, on_invalid)
        try:
            await link.greet(token)
        except RefusedError as exc:
            raise RefusedError(exc.what, f"{exc.reason}; {settings.remedy}") from exc
        yield link
    finally:
        with anyio.move_on_after(CLOSES_WITHIN, shield=True):
            await connection.close()
            await anyio.lowlevel.cancel_shielded_checkpoint()  # its tasks end after it


async def _open(url: str) -> ClientConnection:
    try:
        return await connect(
            url,
            proxy=None,
            compression=None,
            open_timeout=OPENS_WITHIN,
            close_timeout=CLOSES_WITHIN,
            ping_interval=ALIVE_WITHIN,
            ping_timeout=ALIVE_WITHIN,
            max_size=MAX_GREETING_BYTES,
        )
    except TimeoutError as exc:
        raise LinkError(f"{url} did not answer within {OPENS_WITHIN:g} s") from exc
    except (OSError, InvalidHandshake, WebSocketException) as exc:
        problem = connect_problem(exc) if isinstance(exc, OSError) else exc
        raise LinkError(f"{url} cannot be opened: {problem}") from exc
