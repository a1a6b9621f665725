"""Announcements that a program derives from its own list of devices. Pure.

Zigbee2MQTT lists its devices with all that it knows, and announces each value of each device to Home Assistant as well:
34,000 announcements for 4,500 devices. A listed device needs none of them.
"""

from __future__ import annotations

from collections import defaultdict

from homebot.conventions.description import DeviceAnnounced

__all__ = ["DerivedAnnouncements"]


class DerivedAnnouncements:
    """The listed devices, and the announcements that their programs made of them before the list came.

    All announcements here name their program, as the fact ``origin``.
    """

    def __init__(self) -> None:
        self._listed: defaultdict[str, int] = defaultdict(int)
        self._announced: defaultdict[str, dict[str, None]] = defaultdict(dict)

    def is_derived(self, described: DeviceAnnounced) -> bool:
        """Return whether the program that made *described* lists the device itself."""
        return not described.native and any(one in self._listed for one in _marks(described))

    def of(self, listed: DeviceAnnounced) -> tuple[str, ...]:
        """Return the keys of the registered announcements that are derived from *listed*."""
        return tuple({key: None for one in _marks(listed) for key in self._announced.get(one, ())})

    def put(self, described: DeviceAnnounced) -> None:
        """Record a registered announcement."""
        for mark in _marks(described):
            if described.native:
                self._listed[mark] += 1
            else:
                self._announced[mark][described.full_key] = None

    def remove(self, described: DeviceAnnounced) -> None:
        """Record that an announcement is registered no more."""
        for mark in _marks(described):
            if described.native:
                self._listed[mark] -= 1
                if not self._listed[mark]:
                    del self._listed[mark]
            else:
                self._announced[mark].pop(described.full_key, None)
                if not self._announced[mark]:
                    del self._announced[mark]


def _marks(described: DeviceAnnounced) -> list[str]:
    """Return the identifiers of the device, each with the program that announces it."""
    return [f"{described.facts['origin']} {one}" for one in described.identifiers]
