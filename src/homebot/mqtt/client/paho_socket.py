"""The socket of a paho client: below it the native client's transport, beside it the native client's reader.

paho has its TLS context wrap the socket that it connected (`tls_set_context`, `wrap_socket`), and then wants no more
of it than to send and receive; so its wrapper here carries it in the event loop, with TLS or without.
"""

# ruff: noqa: ARG002 - paho's callbacks have fixed parameters

from __future__ import annotations

import asyncio
import socket
import ssl
from typing import Any, final

import anyio
from paho.mqtt import client as paho
from paho.mqtt.properties import Properties

from homebot.errors import WireError
from homebot.mqtt.client.link import ClientLink
from homebot.mqtt.client.receiver import Frame
from homebot.mqtt.client.tcp_transport import TcpTransport
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets.primitives import encode_varint


@final
class PahoSocket:
    """TLS context and socket of one paho client, for one link.

    Args:
        client: The client; it may connect in a thread.
        tls: How to shake hands; None without TLS.
        link: Receives the transport, and passes paho's bytes to `feed`.
    """

    check_hostname = True

    def __init__(self, client: paho.Client, options: MqttOptions, tls: ssl.SSLContext | None, link: ClientLink) -> None:
        self.is_open = False
        self._client = client
        self._options = options
        self._tls = tls
        self._link = link
        self._loop = asyncio.get_running_loop()
        self._connected: socket.socket | None = None
        self._handshake: asyncio.Task[None] | None = None
        self._is_over = self._is_publishing = False
        self._unread = bytearray()  # at most one packet
        client.tls_set_context(self)  # type: ignore[arg-type] # it has all methods that paho uses
        client.on_socket_open, client.on_socket_register_write = self._on_open, self._on_register_write
        client.on_socket_close = client.on_socket_unregister_write = None

    def publish(
        self, topic: str, payload: bytes, qos: int, extra: Properties | None, *, retain: bool
    ) -> paho.MQTTMessageInfo:
        """Have paho publish and write at once, as far as the socket takes it."""
        self._is_publishing = True
        try:
            return self._client.publish(topic, payload, qos, retain, extra)
        finally:
            self._is_publishing = False
            self._flush()

    def feed(self, frame: Frame) -> None:
        """Have paho read one packet.

        Raises:
            WireError: paho stumbled over it.
        """
        if not self.is_open:
            raise WireError("a packet before CONNECT", frame.body)
        self._unread += bytes([frame.first]) + encode_varint(len(frame.body)) + frame.body
        try:
            while self._unread and self._client.socket() is not None:
                self._client.loop_read()
        except Exception as error:  # a decoder may fail in any way
            raise WireError(repr(error), frame.body) from error

    def end(self) -> None:
        """End with the link: send nothing more, and close a connection that is still being made."""
        self._is_over = True
        if self._handshake is not None:
            self._handshake.cancel()

    def wrap_socket(self, sock: socket.socket, **how: object) -> PahoSocket:
        """Take the socket that paho has connected, in paho's thread."""
        self._connected = sock
        return self

    def settimeout(self, seconds: float) -> None:
        """Do nothing; the options have the limit."""

    def setblocking(self, flag: bool) -> None:  # noqa: FBT001 - as sockets have it
        """Do nothing; it never blocks."""

    def do_handshake(self) -> None:
        """Have the event loop carry the connection, in paho's thread; wait until it does."""
        carried = asyncio.run_coroutine_threadsafe(self._carry(), self._loop)
        carried.result(2 * self._options.timeout)  # never that long where the loop runs

    def recv(self, size: int) -> bytes:
        """Return the next of the bytes that are there for paho."""
        if not self._unread:
            raise BlockingIOError
        piece = bytes(self._unread[:size])
        del self._unread[:size]
        return piece

    def send(self, data: bytes) -> int:
        """Write *data*; the rest waits for the broker."""
        if self._link.transport is None or self._is_over:
            raise ConnectionAbortedError("the link has ended")
        self._link.transport.write(data)
        return len(data)

    def fileno(self) -> int:
        """Return the number of the socket, -1 where there is none."""
        return -1 if self._connected is None else self._connected.fileno()

    def close(self) -> None:
        """Send all written data, then close."""
        self.end()
        if self._link.transport is not None:
            self._link.transport.close()

    async def _carry(self) -> None:
        sock = self._connected
        assert sock is not None  # noqa: S101 - private; paho has just given it
        if self._is_over:
            sock.close()
            raise ConnectionAbortedError("the connection attempt was abandoned")
        self._handshake = asyncio.current_task()  # not by paho's thread: it may come to it after the end
        transport = TcpTransport(self._link)
        with anyio.fail_after(self._options.timeout):
            await transport.carry(sock, self._options, self._tls)
        self._link.transport = transport

    def _on_open(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._loop.call_soon_threadsafe(self._begin)

    def _begin(self) -> None:
        if not self._is_over:
            self.is_open = True

    def _on_register_write(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        if not self._is_publishing:
            self._loop.call_soon_threadsafe(self._flush)

    def _flush(self) -> None:
        if not self._is_over:
            self._client.loop_write()
