"""A small rosbridge v2 client for the command line, without an event loop.

Frames are read only while a method waits, so one command does one thing at a time.
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final, NamedTuple, TypeAlias
from urllib.parse import unquote

from websockets.client import ClientProtocol
from websockets.exceptions import InvalidStatus
from websockets.frames import Frame, Opcode
from websockets.http11 import Response
from websockets.protocol import State
from websockets.uri import parse_uri

from homebot.cli.arguments import DEFAULT_CONFIG, set_client_command
from homebot.cli.remarks import remark
from homebot.cli.server_address import ServerAddress, client_context, server_of
from homebot.devices.names import HOME_HEADER
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import LinkError, PeerError, RefusedError, ServiceTimeoutError, UsageError, WireError
from homebot.support.addresses import is_loopback
from homebot.support.connect_errors import connect_problem
from homebot.support.data_folder import data_directory
from homebot.support.owner_token import OWNER_FILE, OWNER_HEADER, owner_proof
from homebot.support.printable import printable

ClientCommand: TypeAlias = "Callable[[DoorClient, argparse.Namespace], int]"

_MAX_WAITING: Final = 10_000  # topic messages that arrive while something else is awaited
_MAX_FRAME: Final = 64 * 1024 * 1024
_FIRST_OF_CBOR: Final = b"\xa0"  # JSON is ASCII
_READ: Final = 256 * 1024
_OPEN_TIMEOUT: Final = 5.0
_CLOSE_TIMEOUT: Final = 1.0
_GRACE: Final = 2.0  # seconds by which the server's own time limit may be late
_NO_RIGHT: Final = "the right "  # the beginning of a refusal because of a missing right


class ReceivedMessage(NamedTuple):
    """A message of a topic.

    Attributes:
        topic: The subscribed topic; for a frame about a goal, its ``op``.
        lost: Messages that were dropped before this one because the reader was too slow.
    """

    topic: str
    message: dict[str, object]
    lost: int


def set_door_command(
    parser: argparse.ArgumentParser, command: ClientCommand, examples: str, *, acts: bool = False
) -> None:
    """Make *parser* run *command*, as :func:`set_client_command` does, and connect before that."""
    set_client_command(parser, lambda options: with_client(options, command), examples, acts=acts)


def with_client(options: argparse.Namespace, command: ClientCommand) -> int:
    """Run *command* with a connection to the homebot in *options*, and return its exit code.

    Raises:
        HomebotError: There was no answer, the server refused the connection, or the command failed.
    """
    address = server_of(options)
    with open_door(address) as door:
        door.as_json = getattr(options, "json", False)
        if address.home and door.home and door.home != address.home:
            raise UsageError(
                f"{DEFAULT_CONFIG} is for the home {address.home!r}, but the homebot on {door.where} serves "
                f"{door.home!r}; give the address with --door, or restart homebot if you changed the name"
            )
        if options.acts and door.home and sys.stderr.isatty():
            print(f"in {door.home} on {door.where}", file=sys.stderr)
        try:
            return command(door, options)
        except KeyError as exc:  # answers are not validated by a model
            raise WireError(f"homebot answered without the field {exc}; is it of another version?") from exc


@contextmanager
def open_door(address: ServerAddress) -> Iterator[DoorClient]:
    """Connect to the homebot that listens at *address*.

    Raises:
        LinkError: There was no answer, or it is not a homebot.
        RefusedError: The server requires another token, or refused the connection.
    """
    host, port = address.host, address.port
    where = address.where
    try:
        connection = socket.create_connection((host, port), _OPEN_TIMEOUT)
    except OSError as exc:
        by = f", the address in {address.source}" if address.source else ""
        if isinstance(exc, socket.gaierror):
            raise LinkError(f"no homebot is running on {where}{by}: {connect_problem(exc)}") from exc
        raise LinkError(f"no homebot is running on {where}{by}; start one with `homebot run`") from exc
    with _secure(connection, address) if address.has_tls else connection as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = DoorClient(connection, where)
        client.shake_hands(address.token, port if not address.token and is_loopback(host) else 0)
        try:
            yield client
        finally:
            client.close()


def _secure(connection: socket.socket, address: ServerAddress) -> socket.socket:
    try:
        return client_context().wrap_socket(connection, server_hostname=address.host)
    except OSError as exc:
        connection.close()
        raise LinkError(
            f"no TLS with {address.where}: {exc}; of a homebot of another computer fetch /authority.crt by a way that "
            "you trust, and name the file in SSL_CERT_FILE"
        ) from exc


class DoorClient:
    """A connection to a running homebot; see :func:`open_door`.

    Attributes:
        home: The name of the server's home; empty before :meth:`shake_hands`.
        as_json: Whether the command prints JSON, also remarks.
    """

    as_json: bool = False

    def __init__(self, connection: socket.socket, where: str) -> None:
        self.home = ""
        self.where = where
        self._connection = connection
        self._protocol = ClientProtocol(parse_uri(f"ws://{where}/"), max_size=_MAX_FRAME)
        self._frames: deque[Frame] = deque()
        self._waiting: deque[ReceivedMessage] = deque(maxlen=_MAX_WAITING)
        self._answers: dict[str, dict[str, object]] = {}
        self._calls = 0

    def call(
        self, service: str, request: Mapping[str, object] | None = None, timeout: float = 5.0
    ) -> dict[str, object]:
        """Return the response of *service*.

        Raises:
            PeerError: There is no such service, or it failed; the message says why.
            ServiceTimeoutError: No response within *timeout* seconds.
            RefusedError: Something sent before was refused.
            LinkError: The connection broke.
        """
        return self.begin_call(service, request, timeout)()

    def ask(self, service: str, request: Mapping[str, object], timeout: float = 5.0) -> JsonMessage:
        """Return the response of *service* if its ``success`` is true, and print its message.

        Raises:
            PeerError: It failed; the message says why. Further errors as for :meth:`call`.
        """
        fields = self.call(service, request, timeout)
        answer, message = JsonMessage(fields), str(fields.get("message", ""))
        if not answer.success:
            raise PeerError(message)
        if message:
            remark(printable(message), as_json=self.as_json)
        return answer

    def begin_call(
        self, service: str, request: Mapping[str, object] | None = None, timeout: float = 5.0
    ) -> Callable[[], dict[str, object]]:
        """Call *service*; return a function that waits for the response, with the errors of :meth:`call`."""
        self._calls += 1
        identifier = f"call:{self._calls}"
        frame = {"op": "call_service", "id": identifier, "service": service, "args": dict(request or {})}
        self._send(frame | {"timeout": timeout, "sent": time.time(), "patience": timeout})
        deadline = time.monotonic() + timeout + _GRACE

        def response() -> dict[str, object]:
            try:
                while identifier not in self._answers:
                    self._read(deadline)
                answer = self._answers.pop(identifier)
            except TimeoutError:
                raise ServiceTimeoutError(service, timeout) from None
            values = answer.get("values")
            if not answer.get("result") or not isinstance(values, dict):
                text = _with_hint(str(values))
                raise PeerError(text if text.startswith("service ") else f"service {service} failed: {text}")
            return values

        return response

    def send_goal(self, action: str, ros_type: str, goal: Mapping[str, object]) -> str:
        """Send *goal* and return its id; its feedback, and finally its result, are frames for :meth:`next`.

        The end of the connection cancels it.
        """
        self._calls += 1
        identifier = f"goal:{self._calls}"
        frame = {"op": "send_action_goal", "id": identifier, "action": action, "action_type": ros_type}
        self._send(frame | {"args": dict(goal), "feedback": True})
        return identifier

    def cancel_goal(self, action: str, identifier: str) -> None:
        """Ask the server of *action* to cancel a goal; its result tells how it ended."""
        self._send({"op": "cancel_action_goal", "id": identifier, "action": action})

    def subscribe(self, topic: str, compression: str = "none") -> None:
        """Subscribe to *topic*, which need not exist yet; ``cbor-raw`` gives ``bytes`` of CDR, ``secs``, ``nsecs``."""
        subscription = {"op": "subscribe", "id": f"subscribing to {topic}", "topic": topic}
        self._send(subscription | {"compression": compression})

    def advertise(self, topic: str, ros_type: str, *, latch: bool = False) -> None:
        """Announce that messages of *ros_type* will be published on *topic*; late readers get the last if *latch*."""
        advertisement = {"op": "advertise", "id": f"advertising {topic}", "topic": topic, "type": ros_type}
        self._send(advertisement | {"latch": latch})

    def publish(self, topic: str, message: Mapping[str, object]) -> None:
        """Publish *message*; an error in it is raised by :meth:`settle`."""
        self._send({"op": "publish", "id": f"publishing on {topic}", "topic": topic, "msg": dict(message)})

    def settle(self) -> None:
        """Wait until everything sent before has been processed.

        Raises:
            RefusedError: Something was refused.
            LinkError: The connection broke.
        """
        self.call("/rosapi/get_time")

    def next(self, timeout: float | None = None) -> ReceivedMessage:
        """Wait for the next message of the subscriptions and return it.

        Raises:
            TimeoutError: None arrived within *timeout* seconds.
            RefusedError: Something sent before was refused.
            LinkError: The connection broke.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while not self._waiting:
            self._read(deadline)
        return self._waiting.popleft()

    def until(self, timeout: float) -> Iterator[ReceivedMessage]:
        """Yield the messages that arrive within *timeout* seconds; errors as for :meth:`next`."""
        deadline = time.monotonic() + timeout
        with suppress(TimeoutError):
            while True:
                yield self.next(max(0.0, deadline - time.monotonic()))

    def shake_hands(self, token: str, own_port: int = 0) -> None:
        """Perform the WebSocket handshake; errors as for :func:`open_door`.

        Args:
            own_port: The port of a rosbridge server of this computer, which is proved the owner's token; 0 for none.
        """
        request = self._protocol.connect()
        if token:
            request.headers["Authorization"] = f"Bearer {token}"
        elif own_port and (own := _own_token()):
            key = request.headers["Sec-WebSocket-Key"]
            request.headers[OWNER_HEADER] = owner_proof(own, key, own_port, time.time())
        self._protocol.send_request(request)
        deadline = time.monotonic() + _OPEN_TIMEOUT
        try:
            self._write()
            while self._is_in(State.CONNECTING) and self._protocol.handshake_exc is None:
                self._receive(deadline)
        except OSError as exc:
            raise LinkError(f"no homebot is running on {self.where}; start one with `homebot run`") from exc
        error = self._protocol.handshake_exc
        if isinstance(error, InvalidStatus):
            raise RefusedError(f"the connection to homebot on {self.where}", _reason(error.response)) from error
        if error is not None:
            raise LinkError(
                f"the server on {self.where} is not a homebot: {error}; give its address with --door, "
                "as wss://HOST:PORT if it has TLS"
            ) from error

    def close(self) -> None:
        """Close the connection, waiting briefly for the server to close it too; idempotent."""
        with suppress(OSError):
            if self._is_in(State.OPEN):
                self._protocol.send_close()
                self._write()
                deadline = time.monotonic() + _CLOSE_TIMEOUT
                while not self._is_in(State.CLOSED):
                    self._receive(deadline)

    def _read(self, deadline: float | None) -> None:
        """Read one frame; topic messages and answers are stored, a refusal is raised."""
        text = self._text(deadline)
        try:
            frame = json.loads(text) if text[:1] < _FIRST_OF_CBOR else _from_cbor(text)
        except (ValueError, RecursionError) as exc:
            raise WireError(f"the rosbridge server sent invalid JSON: {_begin(text)!r}") from exc
        if not isinstance(frame, dict):
            raise WireError(f"the rosbridge server sent something other than a rosbridge frame: {_begin(text)!r}")
        match frame.get("op"):
            case "status":
                # Our identifiers describe the request in words; the server repeats them.
                raise RefusedError(str(frame.get("id", "a frame")), _with_hint(str(frame.get("msg"))))
            case "publish":
                lost = frame.get("lost", 0) + (len(self._waiting) == _MAX_WAITING)
                self._waiting.append(ReceivedMessage(str(frame.get("topic")), frame.get("msg") or {}, lost))
            case "service_response":
                self._answers[str(frame.get("id"))] = frame
            case "action_feedback" | "action_result" as op:
                self._waiting.append(ReceivedMessage(op, frame, 0))

    def _text(self, deadline: float | None) -> bytes:
        """Return the payload of the next message, fragmented or not."""
        parts: list[bytes] = []
        while True:
            while not self._frames:
                self._check_open()
                try:
                    self._receive(deadline)
                except TimeoutError:
                    raise
                except OSError:
                    self._protocol.receive_eof()
            frame = self._frames.popleft()
            parts.append(bytes(frame.data))
            if frame.fin:
                return b"".join(parts)

    def _receive(self, deadline: float | None) -> None:
        """Receive data from the server, waiting until *deadline*; answer frames that require it."""
        left = None if deadline is None else deadline - time.monotonic()
        if left is not None and left <= 0:
            raise TimeoutError
        self._connection.settimeout(left)
        if data := self._connection.recv(_READ):
            self._protocol.receive_data(data)
        else:
            self._protocol.receive_eof()
        for event in self._protocol.events_received():
            if isinstance(event, Frame) and event.opcode in {Opcode.TEXT, Opcode.BINARY, Opcode.CONT}:
                self._frames.append(event)
            elif isinstance(event, Response):
                self.home = unquote(event.headers.get(HOME_HEADER, ""))
        with suppress(OSError):  # it disconnected: its earlier messages count
            self._write()

    def _send(self, frame: Mapping[str, object]) -> None:
        self._check_open()
        self._protocol.send_text(json.dumps(frame).encode())
        try:
            self._write()
        except OSError as exc:
            raise self._explain_end() from exc

    def _write(self) -> None:
        self._connection.settimeout(_OPEN_TIMEOUT)
        for data in self._protocol.data_to_send():
            if data:
                self._connection.sendall(data)

    def _check_open(self) -> None:
        if not self._is_in(State.OPEN):
            raise self._explain_end()

    def _is_in(self, state: State) -> bool:
        return self._protocol.state is state

    def _explain_end(self) -> LinkError:
        received = self._protocol.close_rcvd
        reason = (
            (received.reason or "homebot stopped") if received else "it was cut; homebot crashed, or changed the token"
        )
        return LinkError(f"the connection to homebot ended: {reason}")


def _reason(response: Response) -> str:
    text = (response.body or b"").decode(errors="replace").strip()[:200] or f"HTTP status {response.status_code}"
    hint = "; give it with --token-file or HOMEBOT_DOOR_TOKEN" if text == "a valid token is needed" else ""
    return f"{text}{hint}"


def _with_hint(problem: str) -> str:
    """Return the server's *problem*; if a right is missing, add the next step after changing the configuration."""
    if not problem.startswith(_NO_RIGHT):
        return problem
    has_token = "; the token " in problem
    use_token = "" if has_token else ", and use --token-file FILE or HOMEBOT_DOOR_TOKEN"
    return f"{problem}; then reload homebot (`kill -HUP`){use_token}"


def _from_cbor(frame: bytes) -> object:
    from homebot.conventions.cbor import decode_cbor  # noqa: PLC0415 - loads pydantic

    return decode_cbor(frame, _MAX_FRAME, as_bytes=True)


def _own_token() -> str:
    """Return the owner's token in the data folder; empty if homebot runs as another user, or with another folder."""
    try:
        return (data_directory() / OWNER_FILE).read_text(encoding="utf-8").strip()
    except (OSError, ValueError):
        return ""


def _begin(text: bytes) -> str:
    return text.decode(errors="replace")[:60]
