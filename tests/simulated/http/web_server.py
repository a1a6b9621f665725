"""A small server for simulated devices; the one file of the house that knows aiohttp.

It speaks HTTP, WebSockets and server-sent events. A device answers at once, by functions that never wait. What is sent
to a WebSocket, or as events, waits in a queue of its own: of 100 messages the oldest goes.
"""

import ssl
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import anyio
from aiohttp import WSMsgType, web
from anyio.abc import TaskStatus

QUEUED = 100
MAX_BODY_BYTES = 64 * 1024
SHUTDOWN = 0.1


@dataclass(frozen=True, slots=True)
class WebRequest:
    """A request.

    Attributes:
        method: ``GET``, ``POST``, …
        path: Decoded path, without the query after ``?``.
        headers: The header fields, names in lower case.
    """

    method: str
    path: str
    query: Mapping[str, str]
    headers: Mapping[str, str]
    body: bytes


@dataclass(frozen=True, slots=True)
class WebReply:
    """The answer to a request."""

    body: bytes = b""
    status: int = 200
    content_type: str = "application/json"
    headers: Mapping[str, str] = field(default_factory=dict)


class WebPeer:
    """The other end of a WebSocket, or of a stream of server-sent events.

    Args:
        takes_events: Whether it receives events; a sent text is then one event, without its last line.

    Attributes:
        name: Name given by the client; empty at first.
    """

    def __init__(self, headers: Mapping[str, str] | None = None, *, takes_events: bool = False) -> None:
        self.takes_events = takes_events
        self.headers = headers or {}
        self.name = ""
        self._queue: deque[bytes] = deque(maxlen=QUEUED)
        self._queued = anyio.Event()

    def send(self, text: bytes) -> None:
        """Send a text, in UTF-8; never waits."""
        self._queue.append(text)
        self._queued.set()

    async def next_text(self) -> str:
        """Wait for a text to send, and take it out of the queue."""
        while not self._queue:
            self._queued = anyio.Event()
            await self._queued.wait()
        return self._queue.popleft().decode(errors="replace")


class WebDevice(Protocol):
    """The device behind a server; one that inherits from it has neither pages nor WebSockets by itself."""

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request."""
        del request
        return WebReply(b"Not Found", 404, "text/plain")

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a new WebSocket to *path*, or a new stream of events from there; false if there is none."""

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Handle a WebSocket message."""
        del peer, message


class WebServer:
    """A server for one device, at a free port for 0; its port stays the same however often it is started."""

    def __init__(
        self, device: WebDevice, address: str = "127.0.0.1", port: int = 0, tls: ssl.SSLContext | None = None
    ) -> None:
        self.address = address
        self.port = port
        self.peers: list[WebPeer] = []
        self.tls = tls
        self._device = device

    def broadcast(self, text: bytes) -> None:
        """Send a text to all WebSockets; never waits."""
        for peer in self.peers:
            if not peer.takes_events:
                peer.send(text)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled; then all connections are cut."""
        app = web.Application(client_max_size=MAX_BODY_BYTES)
        app.router.add_route("*", "/{path:.*}", self._handle)
        runner = web.AppRunner(app, shutdown_timeout=SHUTDOWN, handler_cancellation=True, access_log=None)
        await runner.setup()
        try:
            await web.TCPSite(runner, self.address, self.port, ssl_context=self.tls).start()
            self.port = int(runner.addresses[0][1])
            task_status.started()
            await anyio.sleep_forever()
        finally:
            with anyio.CancelScope(shield=True):
                await runner.cleanup()

    async def _handle(self, request: web.Request) -> web.StreamResponse:
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._talk(request)
        headers = {name.lower(): value for name, value in request.headers.items()}
        if "text/event-stream" in headers.get("accept", ""):
            peer = WebPeer(headers, takes_events=True)
            if self._device.greet(peer, request.path):
                return await self._send_events(request, peer)
        asked = WebRequest(request.method, request.path, dict(request.query), headers, await request.read())
        reply = self._device.answer(asked)
        return web.Response(
            body=reply.body, status=reply.status, content_type=reply.content_type, headers=dict(reply.headers)
        )

    async def _send_events(self, request: web.Request, peer: WebPeer) -> web.StreamResponse:
        stream = web.StreamResponse(headers={"Content-Type": "text/event-stream", "Cache-Control": "no-store"})
        await stream.prepare(request)
        self.peers.append(peer)
        try:
            while True:
                await stream.write(f"{await peer.next_text()}\n\n".encode())
        except ConnectionError:
            return stream  # the peer has left
        finally:
            self.peers.remove(peer)

    async def _talk(self, request: web.Request) -> web.StreamResponse:
        peer = WebPeer()
        if not self._device.greet(peer, request.path):
            raise web.HTTPNotFound
        socket = web.WebSocketResponse(max_msg_size=MAX_BODY_BYTES, timeout=SHUTDOWN)
        await socket.prepare(request)
        self.peers.append(peer)
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(_send_texts, socket, peer)
                async for message in socket:
                    if message.type is WSMsgType.TEXT:
                        self._device.receive(peer, message.data.encode(errors="replace"))
                tasks.cancel_scope.cancel()
        finally:
            self.peers.remove(peer)
        return socket


async def _send_texts(socket: web.WebSocketResponse, peer: WebPeer) -> None:
    while not socket.closed:
        text = await peer.next_text()
        try:
            await socket.send_str(text)
        except ConnectionError:  # the peer has left; the reader notices as well
            return
