"""The guard of this computer: a host on the network may not lead homebot to local services.

Names are judged by the addresses that they are resolved to, at the moment of the connection: ``127.1``,
``[::ffff:127.0.0.1]``, ``0.0.0.0``, the name of this computer, and a name of the internet may all lead here.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable
from typing import TypeAlias, cast

from homebot.errors import RefusedError
from homebot.support.addresses import parse_address

__all__ = ["AddressGuard", "OwnAddressError", "guard_for"]

SocketAddress: TypeAlias = tuple[str, int] | tuple[str, int, int, int]

_ANY_PORT = 9


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
    (family, kind, _, _, place), *_ = socket.getaddrinfo(
        str(known) if known.version == 4 else text, _ANY_PORT, type=socket.SOCK_DGRAM, flags=socket.AI_NUMERICHOST
    )
    with socket.socket(family, kind) as probe:
        probe.setblocking(False)  # noqa: FBT003 - the socket module's own
        try:
            probe.connect(place)
        except OSError:
            return False  # no route leads there
        own: str = probe.getsockname()[0]
        return parse_address(own) == known
