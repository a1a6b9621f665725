"""Drives the socket of a paho client from the running event loop, by what paho documents for that."""

# ruff: noqa: ARG002 - paho's callbacks have fixed parameters

from __future__ import annotations

import asyncio
import socket
import ssl
from collections.abc import Callable
from typing import Any, Final, final

import anyio
from paho.mqtt import client as paho

from homebot.mqtt.client.tcp_transport import acknowledge_at_once

__all__ = ["PahoSocket"]

_AT_ONCE: Final = 50  # packets that are read in one turn of the loop


@final
class PahoSocket:
    """The socket of one paho client, for one link.

    aiomqtt has the same, which watches the number of a socket that may be closed already, and another's by then.

    Args:
        client: The client; it may connect in a thread.
        on_broken: Told what paho's decoder stumbled over; ends the link.

    Attributes:
        is_open: True once the connection was made.
    """

    def __init__(self, client: paho.Client, on_broken: Callable[[Exception], None]) -> None:
        self.is_open = False
        self._client = client
        self._on_broken = on_broken
        self._loop = asyncio.get_running_loop()
        self._socket: socket.socket | None = None
        self._is_over = False
        self._is_stuck = False
        self._drained = anyio.Event()
        self._received = 0
        self._tick: asyncio.TimerHandle | None = None
        client.on_socket_open, client.on_socket_close = self._on_open, self._on_close
        client.on_socket_register_write = self._on_register_write
        client.on_socket_unregister_write = self._on_unregister_write

    def note_received(self) -> None:
        """Count a packet, so that the next one is read in the same turn of the loop."""
        self._received += 1

    def flush(self) -> None:
        """Write now what paho has queued, as far as the socket takes it."""
        if self._socket is None:
            return
        self._client.loop_write()
        if self._client.socket() is not None and self._client.want_write() and not self._is_stuck:
            self._is_stuck = True
            self._drained = anyio.Event()
            self._loop.add_writer(self._socket.fileno(), self.flush)

    async def wait_until_taken(self) -> None:
        """Wait while the broker takes nothing; no longer where the link ends."""
        while self._is_stuck:
            await self._drained.wait()

    def close(self) -> None:
        """Close the socket without a word, also one that is still being connected."""
        self._is_over = True
        if self._socket is not None:
            sock = self._socket
            self._on_close(self._client, None, sock)
            sock.close()

    def _on_open(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._loop.call_soon_threadsafe(self._watch, sock)

    def _watch(self, sock: socket.socket) -> None:
        if self._is_over:  # the connect was given up
            sock.close()
            return
        self._socket = sock
        self.is_open = True
        self._loop.add_reader(sock.fileno(), self._read)
        self._keep_alive()
        self.flush()

    def _on_close(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        if self._tick is not None:
            self._tick.cancel()
        if self._socket is not None:
            self._loop.remove_reader(self._socket.fileno())
            self._free_writers()
            self._socket = None

    def _on_register_write(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._loop.call_soon_threadsafe(self.flush)

    def _on_unregister_write(self, client: paho.Client, userdata: Any, sock: Any) -> None:
        self._free_writers()

    def _free_writers(self) -> None:
        if self._is_stuck and self._socket is not None:
            self._loop.remove_writer(self._socket.fileno())
        self._is_stuck = False
        self._drained.set()

    def _keep_alive(self) -> None:
        self._client.loop_misc()
        if self._socket is not None:
            self._tick = self._loop.call_later(min(1.0, self._client.keepalive / 8), self._keep_alive)

    def _read(self) -> None:
        for _ in range(_AT_ONCE):
            sock, before = self._socket, self._received
            if sock is None:
                return
            try:
                self._client.loop_read()
            except Exception as error:  # noqa: BLE001 - there is no telling what a decoder stumbles over
                self._on_broken(error)
                return
            is_decrypted = isinstance(sock, ssl.SSLSocket) and self._socket is not None and sock.pending() > 0
            if before == self._received and not is_decrypted:
                break
        else:
            self._loop.call_soon(self._read)  # what TLS has decrypted wakes no reader
        if self._socket is not None:
            acknowledge_at_once(self._socket)
