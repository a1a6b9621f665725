"""The network interfaces of this computer, and when they change. The only file that imports ifaddr."""

from __future__ import annotations

import ipaddress
import socket
from typing import TypeAlias

import anyio

__all__ = ["Interfaces", "NetworkInterfaces"]

Interfaces: TypeAlias = tuple[str | int, ...]
"""IPv4 addresses, and the indexes of interfaces that have IPv6: as zeroconf wants them."""

LOOK_EVERY = 2.0
"""Seconds between two checks of the interfaces; one check takes about 0.2 ms."""


class NetworkInterfaces:
    """The network interfaces of this computer; the host may provide others."""

    def find(self, wanted: tuple[str, ...]) -> Interfaces:
        """Return the present interfaces.

        Args:
            wanted: Names or addresses; empty for all but loopback.
        """
        import ifaddr  # noqa: PLC0415 - an extra

        found: list[str | int] = []
        for adapter in ifaddr.get_adapters():
            texts = [ip.ip if isinstance(ip.ip, str) else ip.ip[0] for ip in adapter.ips]
            addresses = [ipaddress.ip_address(text) for text in texts]
            is_wanted = adapter.name in wanted if wanted else not any(one.is_loopback for one in addresses)
            named = [text for text in texts if is_wanted or text in wanted]
            found += [text for text in named if ":" not in text]
            local = next((one for one in addresses if one.version == 6 and one.is_link_local), None)
            if local is not None and adapter.index is not None and any(":" in text for text in named):
                found += [adapter.index] if _is_ready(str(local), adapter.index) else []
        return tuple(dict.fromkeys(found))

    async def wait_for_change(self, wanted: tuple[str, ...], before: Interfaces) -> Interfaces:
        """Wait until the interfaces differ from *before*, and return them."""
        while (now := self.find(wanted)) == before:  # noqa: ASYNC110 - the system sends no event
            await anyio.sleep(LOOK_EVERY)
        return now


def _is_ready(address: str, index: int) -> bool:
    """Return whether a link-local address can be used yet: duplicate detection takes some seconds."""
    with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, 0, 0, index))
        except OSError:
            return False
    return True
