"""About how much memory what stands takes, in the gateway and in the directory, and how much it may take. Pure.

Measured: a device takes 15 kB with its one announcement and part, a further announcement of it 8 kB, a further part of
an announcement 3 kB. What announcements are longer than that explains is the account of
:mod:`homebot.gateways.mqtt.excess`.
"""

from __future__ import annotations

from homebot.conventions.description import DeviceAnnounced
from homebot.errors import WireError

__all__ = ["MAX_MEMORY", "MemoryAccount"]

MAX_MEMORY = 512 * 1024 * 1024
"""Bytes of all: 30,000 devices with one announcement each, or all 4,478 models of Zigbee2MQTT by both of their ways."""

_DEVICE = 8 * 1024
_ANNOUNCEMENT = 5 * 1024
_PART = 3 * 1024


class MemoryAccount:
    """The account of what stands.

    Args:
        most: Bytes of all, about.

    Attributes:
        total: Bytes of all that stand, about.
    """

    def __init__(self, most: int = MAX_MEMORY) -> None:
        self.total = 0
        self._most = most
        self._devices: dict[tuple[str, ...], int] = {}

    def check(self, described: DeviceAnnounced, before: DeviceAnnounced | None) -> None:
        """Let *described* stand in place of *before*; one that takes no more than that always may.

        Raises:
            WireError: There is no more room for it.
        """
        more = _size(described) - (0 if before is None else _size(before))
        if _who(described) not in self._devices:
            more += _DEVICE
        if more > 0 and self.total + more > self._most:
            raise WireError(
                f"{described.key!r} is one too many: announcements take {self.total:,} bytes already, and "
                f"{self._most:,} is the limit; withdraw some, or raise max_memory of the gateway"
            )

    def put(self, described: DeviceAnnounced) -> None:
        """Count what stands from now on."""
        who = _who(described)
        count = self._devices.get(who, 0)
        self._devices[who] = count + 1
        self.total += _size(described) + (0 if count else _DEVICE)

    def drop(self, described: DeviceAnnounced) -> None:
        """Count no more what was put before."""
        who = _who(described)
        self._devices[who] -= 1
        self.total -= _size(described)
        if not self._devices[who]:
            del self._devices[who]
            self.total -= _DEVICE


def _who(described: DeviceAnnounced) -> tuple[str, ...]:
    """Announcements with the same identifiers are one device; one without any is a device by itself."""
    return described.identifiers or (described.convention, described.key)


def _size(described: DeviceAnnounced) -> int:
    return _ANNOUNCEMENT + _PART * len(described.parts)
