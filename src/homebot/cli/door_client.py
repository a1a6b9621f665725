"""The command line's end of the door: a small rosbridge v2 client.

The only file that imports the WebSocket client. Frames are read only while something is awaited here, so one command
does one thing at a time and needs no task of its own.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidMessage, InvalidStatus

from homebot.errors import LinkError, PeerError, RefusedError, ServiceTimeoutError, WireError

__all__ = ["DoorClient", "ReceivedMessage", "open_door"]

_MAX_WAITING = 10_000  # messages of topics that come while something else is awaited
_MAX_FRAME = 64 * 1024 * 1024
_OPEN_TIMEOUT = 5.0
_SKIP_AT_MOST = 1.0  # seconds
_GRACE = 2.0  # seconds by which the door's own time limit may be late


@dataclass(frozen=True, slots=True)
class ReceivedMessage:
    """A message of a topic.

    Attributes:
        topic: The topic, as it was subscribed to.
        message: Its fields.
        lost: Messages that were dropped before this one because the reader was too slow.
    """

    topic: str
    message: dict[str, object]
    lost: int


class DoorClient:
    """A connection to a running homebot; see :func:`open_door`."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._waiting: deque[ReceivedMessage] = deque(maxlen=_MAX_WAITING)
        self._calls = 0

    async def report_errors(self) -> None:
        """Ask to be told when something sent is refused."""
        await self._send({"op": "set_level", "level": "error"})

    async def call(
        self,
        service: str,
        request: Mapping[str, object] | None = None,
        timeout: float = 5.0,  # noqa: ASYNC109
    ) -> dict[str, object]:
        """Return the response of *service*.

        Raises:
            PeerError: There is no such service, or it failed; the message says why.
            ServiceTimeoutError: No response within *timeout* seconds.
            RefusedError: Something sent before was refused.
            LinkError: The connection broke.
        """
        self._calls += 1
        identifier = f"call:{self._calls}"
        frame = {"op": "call_service", "id": identifier, "service": service, "args": dict(request or {})}
        await self._send(frame | {"timeout": timeout})
        try:
            with anyio.fail_after(timeout + _GRACE):
                answer = await self._answer(identifier)
        except TimeoutError:
            raise ServiceTimeoutError(service, timeout) from None
        values = answer.get("values")
        if not answer.get("result") or not isinstance(values, dict):
            text = str(values)
            raise PeerError(text if text.startswith("service ") else f"service {service} failed: {text}")
        return values

    async def subscribe(self, topic: str) -> None:
        """Ask for the messages of *topic*; one that does not exist yet is fine."""
        await self._send({"op": "subscribe", "id": f"subscribing to {topic}", "topic": topic})

    async def advertise(self, topic: str, ros_type: str) -> None:
        """Announce that messages of *ros_type* will come for *topic*."""
        await self._send({"op": "advertise", "id": f"advertising {topic}", "topic": topic, "type": ros_type})

    async def publish(self, topic: str, message: Mapping[str, object]) -> None:
        """Publish *message*; what is wrong with it shows in :meth:`settle`."""
        await self._send({"op": "publish", "id": f"publishing on {topic}", "topic": topic, "msg": dict(message)})

    async def settle(self) -> None:
        """Wait until everything sent before has been dealt with.

        Raises:
            RefusedError: Some of it was refused.
            LinkError: The connection broke.
        """
        await self.call("/rosapi/get_time")

    async def skip_kept(self) -> None:
        """Pass over what publishers keep for late joiners, which comes in one go after :meth:`subscribe`.

        Live messages that come in between are passed over too.

        Raises:
            RefusedError: Something sent before was refused.
            LinkError: The connection broke.
        """
        with anyio.move_on_after(_SKIP_AT_MOST):  # a topic that is busy all the time never pauses
            while True:
                self._waiting.clear()
                await self.settle()
                if not self._waiting:
                    return

    async def next(self) -> ReceivedMessage:
        """Return the next message of what was subscribed to, waiting for it.

        Raises:
            RefusedError: Something sent before was refused.
            LinkError: The connection broke.
        """
        while not self._waiting:
            await self._read()
        return self._waiting.popleft()

    async def _answer(self, identifier: str) -> dict[str, object]:
        while True:
            frame = await self._read()
            if frame.get("op") == "service_response" and frame.get("id") == identifier:
                return frame

    async def _read(self) -> dict[str, object]:
        """Read one frame; a message of a topic is put aside, a refusal is raised."""
        try:
            text = await self._connection.recv(decode=True)
        except ConnectionClosed as exc:
            raise _ended(exc) from exc
        try:
            frame = json.loads(text)
        except ValueError as exc:
            raise WireError(f"the rosbridge server sent invalid JSON: {text[:60]!r}") from exc
        if not isinstance(frame, dict):
            raise WireError(f"the rosbridge server sent something other than a rosbridge frame: {text[:60]!r}")
        if frame.get("op") == "status":
            # Our identifiers say in words what was asked for; the door repeats them.
            raise RefusedError(str(frame.get("id", "a frame")), str(frame.get("msg")))
        if frame.get("op") == "publish":
            lost = frame.get("lost", 0) + (len(self._waiting) == _MAX_WAITING)
            self._waiting.append(ReceivedMessage(str(frame.get("topic")), frame.get("msg") or {}, lost))
        return frame

    async def _send(self, frame: Mapping[str, object]) -> None:
        try:
            await self._connection.send(json.dumps(frame))
        except ConnectionClosed as exc:
            raise _ended(exc) from exc


@asynccontextmanager
async def open_door(host: str, port: int, token: str = "") -> AsyncIterator[DoorClient]:
    """Connect to the homebot that listens on *host* and *port*.

    Raises:
        LinkError: Nobody answers there, or it is no homebot.
        RefusedError: The door wants another token, or does not let us in.
    """
    where = f"{f'[{host}]' if ':' in host else host}:{port}"
    connection = await _connect(where, token)
    try:
        client = DoorClient(connection)
        await client.report_errors()
        yield client
    finally:
        with anyio.CancelScope(shield=True):
            await connection.close()


async def _connect(where: str, token: str) -> ClientConnection:
    try:
        return await connect(
            f"ws://{where}/",
            additional_headers={"Authorization": f"Bearer {token}"} if token else None,
            compression=None,
            max_size=_MAX_FRAME,
            open_timeout=_OPEN_TIMEOUT,
            close_timeout=1.0,
            proxy=None,
        )
    except InvalidStatus as exc:
        raise RefusedError(f"the connection to homebot on {where}", _reason(exc)) from exc
    except (OSError, TimeoutError) as exc:
        raise LinkError(f"no homebot is running on {where}; start one with `homebot run`") from exc
    except (InvalidHandshake, InvalidMessage) as exc:
        raise LinkError(f"the server on {where} is not a homebot: {exc}") from exc


def _ended(error: ConnectionClosed) -> LinkError:
    reason = error.rcvd.reason if error.rcvd else ""
    return LinkError(f"the connection to homebot ended: {reason or 'homebot stopped'}")


def _reason(error: InvalidStatus) -> str:
    body = error.response.body or b""
    text = body.decode(errors="replace").strip()[:200] or f"HTTP status {error.response.status_code}"
    hint = "; give it with --token-file or HOMEBOT_DOOR_TOKEN" if error.response.status_code == 401 else ""
    return f"{text}{hint}"
