"""Ports of this machine that a test gives to a program which it starts."""

import atexit
import socket
from contextlib import ExitStack

_reserved = ExitStack()
atexit.register(_reserved.close)


def reserve_port() -> int:
    """Return a TCP port of 127.0.0.1 at which nobody listens, for a server that may reuse addresses, as all of ours do.

    It is kept bound until these tests end: nobody else is given it before the server listens, nor after it has ended.
    """
    reserved = _reserved.enter_context(socket.socket())
    reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    reserved.bind(("127.0.0.1", 0))
    port: int = reserved.getsockname()[1]
    return port


def reserve_datagram_port() -> int:
    """Return a UDP port of 127.0.0.1 at which nobody listens, for a server that may share ports, as aiocoap's do.

    Likewise kept until these tests end. What keeps it is connected, so that no datagram of others comes to it.
    """
    reserved = _reserved.enter_context(socket.socket(type=socket.SOCK_DGRAM))
    reserved.bind(("127.0.0.1", 0))
    port: int = reserved.getsockname()[1]
    reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)  # after it has a port of its own
    reserved.connect(("127.0.0.1", port))
    return port


def reserve_door() -> str:
    """Return the address of a door for which a port is reserved."""
    return f"127.0.0.1:{reserve_port()}"
