"""The guard of this computer: a host on the network may not lead homebot to local services.

Names are judged by the addresses that they are resolved to, at the moment of the connection: ``127.1``,
``[::ffff:127.0.0.1]``, ``0.0.0.0``, the name of this computer, and a name of the internet may all lead here.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TypeAlias, cast

from homebot.errors import RefusedError
from homebot.support.addresses import parse_address

__all__ = ["AddressGuard", "OwnAddressError", "guard_for"]

SocketAddress: TypeAlias = tuple[str, int] | tuple[str, int, int, int]


class OwnAddressError(OSError):
    """A connection that would lead to this computer."""

    def __init__(self) -> None:
        super().__init__("it leads to this computer, which another host does not speak for")

    def refusal_of(self, what: str) -> RefusedError:
        """Return the error of the request *what*."""
        return RefusedError(what, f"{self}; use a directory on this computer, or configure its address")


class AddressGuard:
    """A check of the addresses that a client connects to.

    Args:
        allowed: Addresses of this computer that may be connected to.
    """

    def __init__(self, allowed: Iterable[str] = ()) -> None:
        self._allowed = frozenset(parse_address(one) for one in allowed)

    def check(self, found: SocketAddress) -> str:
        """Return an address that is about to be connected to, as text: ``10.0.0.7``, ``fe80::1%eth0``.

        Raises:
            OwnAddressError: It is one of this computer.
        """
        text = socket.getnameinfo(found, socket.NI_NUMERICHOST | socket.NI_NUMERICSERV)[0]
        if parse_address(text) not in self._allowed and _is_own(text):
            raise OwnAddressError
        return text

    async def resolve(self, host: str, port: int) -> str:
        """Return the address of *host*, as text.

        Raises:
            OwnAddressError: One of its addresses is one of this computer.
            OSError: It has none.
        """
        loop = asyncio.get_running_loop()
        try:
            found = await loop.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except UnicodeError:
            raise OSError("it is no name of a host") from None
        checked = [self.check(cast("SocketAddress", address)) for *_, address in found]
        return checked[0]


async def guard_for(host: str | None) -> AddressGuard | None:
    """Return the guard for addresses that *host* describes; None for this computer, which may describe any."""
    guard = AddressGuard()
    try:
        await guard.resolve(host or "", 0)
    except OwnAddressError:
        return None
    except OSError:
        pass  # it cannot be connected to either
    return guard


def _is_own(text: str) -> bool:
    """Return whether the kernel would deliver packets for an address on this computer; none is sent."""
    known = parse_address(text)
    if known is None or known.is_loopback or known.is_unspecified or known.is_multicast:
        return True  # all hosts of a group are meant: this one, and those of others
    host = str(known) if known.version == 4 else text
    if _can_bind(_FOREIGN[known.version]):  # by net.ipv4.ip_nonlocal_bind any address can be bound
        return _has_itself_as_source(host)
    return _can_bind(host)


_FOREIGN = {4: "192.0.2.1", 6: "2001:db8::1"}
"""Addresses for documentation, which no computer has."""


def _can_bind(host: str) -> bool:
    """Return whether a socket can be bound to an address; a broadcast address is this computer's as well."""
    with _socket_for(host) as (probe, place):
        try:
            probe.bind(place)
        except OSError:
            return False
        return True


def _has_itself_as_source(host: str) -> bool:
    """Return whether packets for an address would come from it: not for a second address in one network."""
    with _socket_for(host) as (probe, place):
        try:
            probe.connect(place)
        except OSError:
            return False  # no route leads there
        return parse_address(probe.getsockname()[0]) == parse_address(host)


@contextmanager
def _socket_for(host: str) -> Iterator[tuple[socket.socket, SocketAddress]]:
    (family, kind, _, _, place), *_ = socket.getaddrinfo(
        host, None, type=socket.SOCK_DGRAM, flags=socket.AI_NUMERICHOST
    )
    with socket.socket(family, kind) as probe:
        probe.setblocking(False)  # noqa: FBT003 - the socket module's own
        yield probe, cast("SocketAddress", place)
