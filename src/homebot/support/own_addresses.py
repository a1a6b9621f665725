"""The addresses by which others in the network reach this computer."""

import contextlib
import socket
from typing import Final

_ELSEWHERE: Final = ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1"))
"""Addresses for documentation (RFC 5737, RFC 3849): the way to them shows this computer's own; nothing is sent."""


def own_addresses() -> list[str]:
    """Return the addresses, IPv4 first; none without a network."""
    addresses = []
    for family, elsewhere in _ELSEWHERE:
        with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((elsewhere, 9))
            addresses.append(probe.getsockname()[0])
    return addresses
