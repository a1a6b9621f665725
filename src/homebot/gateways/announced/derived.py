"""Announcements that a program derives from its own list of devices. Pure.

Zigbee2MQTT lists its devices with all that it knows, and announces each value of each device to Home Assistant as well:
34,000 announcements for 4,500 devices. A listed device needs none of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from homebot.conventions.description import DeviceAnnounced

__all__ = ["LISTED", "DerivedAnnouncements"]

LISTED = "the list of its bridge describes the device"
"""Why an announcement is removed."""


class DerivedAnnouncements:
    """The listed devices, and the announcements that their programs made of them before the list came.

    All announcements here name their program, as the fact ``origin``.
    """

    def __init__(self) -> None:
        self._registered: defaultdict[str, dict[str, DeviceAnnounced]] = defaultdict(dict)

    def is_derived(self, described: DeviceAnnounced) -> bool:
        """Return whether the program that made *described* lists the device itself."""
        return not described.native and any(one.native and _describes(one, described) for one in self._like(described))

    def of(self, listed: DeviceAnnounced) -> tuple[str, ...]:
        """Return the keys of the registered announcements that are derived from *listed*."""
        derived = [one.full_key for one in self._like(listed) if not one.native and _describes(listed, one)]
        return tuple(dict.fromkeys(derived))

    def put(self, described: DeviceAnnounced) -> None:
        """Record a registered announcement."""
        for mark in _marks(described):
            self._registered[mark][described.full_key] = described

    def remove(self, described: DeviceAnnounced) -> None:
        """Record that an announcement is registered no more."""
        for mark in _marks(described):
            self._registered[mark].pop(described.full_key, None)
            if not self._registered[mark]:
                del self._registered[mark]

    def _like(self, described: DeviceAnnounced) -> Iterator[DeviceAnnounced]:
        """Yield what is registered of the same device by the same program."""
        for mark in _marks(described):
            yield from self._registered.get(mark, {}).values()


def _marks(described: DeviceAnnounced) -> list[str]:
    """Return the identifiers of the device, each with the program that announces it."""
    return [f"{described.facts['origin']} {one}" for one in described.identifiers]


def _describes(listed: DeviceAnnounced, announced: DeviceAnnounced) -> bool:
    """Return whether *announced* is at a topic of *listed*: a bridge that moved leaves its old list on the broker."""
    return any(one.part.is_below(listed.owns) for one in announced.parts)
