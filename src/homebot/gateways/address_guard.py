"""The guard of this computer: hosts on the network must not lead homebot to local services.

Names are judged by the addresses that they resolve to at the moment of connecting: ``127.1``, ``[::ffff:127.0.0.1]``,
``0.0.0.0``, the name of this computer and a name on the internet may all lead here.
"""

import asyncio
import socket
import struct
from collections.abc import Iterable
from ipaddress import IPv4Address, IPv6Network
from typing import TypeAlias, cast

from homebot.errors import RefusedError
from homebot.support.addresses import parse_address

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

    Attributes:
        of_described: The guard for addresses that the host describes; None for this computer, which may describe any.
    """

    def __init__(self, allowed: Iterable[str] = ()) -> None:
        self.of_described: AddressGuard | None = self
        self._allowed = frozenset(parse_address(text) for text in allowed)

    def check(self, address: SocketAddress) -> str:
        """Return an address that is about to be connected to, as text: ``10.0.0.7``, ``fe80::1%eth0``.

        Raises:
            OwnAddressError: It is one of this computer.
        """
        text, is_own = _judge(address)
        if is_own and parse_address(text) not in self._allowed:
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
            infos = await loop.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except UnicodeError:
            raise OSError("it is no name of a host") from None
        checked = [self.check(cast("SocketAddress", address)) for *_, address in infos]
        return checked[0]


class ThisComputerGuard(AddressGuard):
    """A check that a client stays at this computer: a name may resolve to another address the next time."""

    def __init__(self) -> None:
        super().__init__()
        self.of_described = None

    def check(self, address: SocketAddress) -> str:
        """Return an address, as :meth:`AddressGuard.check`.

        Raises:
            OSError: It is one of another host.
        """
        text, is_own = _judge(address)
        if not is_own:
            raise OSError("its name leads to another host now, not to this computer")
        return text


async def guard_for(host: str | None) -> AddressGuard:
    """Return the guard for connections to *host*, including that for addresses that the host describes.

    A name that leads to this computer and to another host is not this computer.
    """
    here = ThisComputerGuard()
    try:
        await here.resolve(host or "", 0)
    except OSError:
        return AddressGuard()
    return here


def _judge(address: SocketAddress) -> tuple[str, bool]:
    text = socket.getnameinfo(address, socket.NI_NUMERICHOST | socket.NI_NUMERICSERV)[0]
    return text, _is_own(text, address[3] if len(address) > 3 else 0)


def _is_own(text: str, scope: int) -> bool:
    """Return whether the kernel would deliver packets for an address on this computer; none is sent."""
    known = parse_address(text)
    if known is not None and known in _NAT64:
        known = IPv4Address(known.packed[-4:])
    if known is None or known.is_loopback or known.is_unspecified or known.is_multicast:
        return True
    if known.version == 4 or not known.is_link_local:
        scope = 0  # ignored by the kernel for other addresses
    try:
        return _route_kind(known.packed, scope) in _ROUTES_HERE
    except (AttributeError, OSError):  # not on Linux, or not allowed
        return _can_bind((str(known), 0) if known.version == 4 else (str(known), 0, 0, scope))


_NAT64 = IPv6Network("64:ff9b::/96")
"""RFC 6052: a router on the way translates these addresses to IPv4, also those of this computer."""

_ROUTES_HERE = frozenset({2, 3, 4, 5})
"""RTN_LOCAL, RTN_BROADCAST, RTN_ANYCAST and RTN_MULTICAST; of some, no socket can be bound to the address."""

_NEW_ROUTE, _GET_ROUTE, _REQUEST, _DESTINATION, _INTERFACE = 24, 26, 1, 1, 4


def _route_kind(address: bytes, scope: int) -> int:
    """Return the kind of the route to an address, 0 if there is none; see rtnetlink(7)."""
    family = socket.AF_INET if len(address) == 4 else socket.AF_INET6
    body = struct.pack("=8BI", family, 8 * len(address), 0, 0, 0, 0, 0, 0, 0)
    body += struct.pack("=HH", 4 + len(address), _DESTINATION) + address
    if scope:
        body += struct.pack("=HHI", 8, _INTERFACE, scope)
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_NONBLOCK, 0) as asked:
        asked.send(struct.pack("=IHHII", 16 + len(body), _GET_ROUTE, _REQUEST, 1, 0) + body)
        answer = asked.recv(4096)
    return answer[23] if struct.unpack_from("=H", answer, 4)[0] == _NEW_ROUTE else 0


def _can_bind(place: SocketAddress) -> bool:
    with socket.socket(socket.AF_INET if len(place) == 2 else socket.AF_INET6, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(place)
        except OSError:
            return False
        return True
