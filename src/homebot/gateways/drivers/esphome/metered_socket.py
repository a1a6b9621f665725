"""A TCP socket with a small receive buffer and a limit on the rate of received data."""

import asyncio
import codecs
import socket

import anyio

from homebot.support.rate_limit import RateLimit

__all__ = ["BURST", "PER_SECOND", "RECEIVED_AT_ONCE", "MeteredSocket", "open_socket"]

codecs.lookup("idna")  # getaddrinfo uses it; its first use loads a module: here, and not while the event loop runs

RECEIVED_AT_ONCE = 8 * 1024
"""Bytes; Linux takes twice that. All that came is handled without a pause, and 256 KiB of tiny frames take a second."""

BURST, PER_SECOND = 512 * 1024, 64 * 1024
"""Bytes that may come at once, and each second after that: the entity list of a large device, and a hundred times
its reports. More keeps homebot busy, and each ping is answered, whether the device reads the answers or not."""

CONNECT_WITHIN = 10.0
"""Seconds for a connection."""


class MeteredSocket(socket.socket):
    """A TCP socket that fails when the peer sends more than :data:`PER_SECOND`."""

    def __init__(self, family: int, kind: int, protocol: int) -> None:
        super().__init__(family, kind, protocol)
        self.is_flooded = False
        self._limit = RateLimit(PER_SECOND, BURST)

    def limit_buffer(self) -> None:
        """Keep the receive buffer of the kernel small."""
        self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED_AT_ONCE)

    def recv(self, bufsize: int, flags: int = 0, /) -> bytes:
        """Return received data."""
        data = super().recv(bufsize, flags)
        if self._limit.charge(asyncio.get_running_loop().time(), len(data)) > 0:
            self.is_flooded = True
            raise ConnectionAbortedError("the device sends too much data")
        return data


async def open_socket(address: str, port: int) -> MeteredSocket:
    """Return a socket that is connected to *address*."""
    (family, kind, protocol, _, place), *_ = socket.getaddrinfo(
        address, port, type=socket.SOCK_STREAM, flags=socket.AI_NUMERICHOST
    )
    made = MeteredSocket(family, kind, protocol)
    try:
        made.setblocking(False)  # noqa: FBT003 - the standard library wants it so
        made.limit_buffer()
        with anyio.fail_after(CONNECT_WITHIN):
            await asyncio.get_running_loop().sock_connect(made, place)
    except BaseException:
        made.close()
        raise
    return made
