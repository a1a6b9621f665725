"""Excess length of announcements over what they offer, and its limits. Pure.

A house with many devices has many announcements, each as long as the parts that it tells of. Who wants memory has long
ones: of lists, of templates. Only what an announcement is longer than an honest one of as many parts counts here.
"""

from __future__ import annotations

from homebot.conventions.description import DeviceAnnounced
from homebot.devices.text_size import size_of_parts, size_of_texts
from homebot.errors import WireError

__all__ = ["MAX_EXCESS", "MAX_EXCESS_EACH", "Excess", "excess_of"]

MAX_EXCESS = 8 * 1024 * 1024
"""Bytes of all. In memory they are two to twelve times as much: the texts of lists two, templates twelve."""

MAX_EXCESS_EACH = 256 * 1024
"""Bytes of one: as long as a message may be that announces one device."""

_FREE = 3 * 1024
_FREE_PART = 1024
"""Bytes that are no excess: of one announcement, and of each of its parts. Of 1,495 configs that Zigbee2MQTT makes of
real devices, one part each, the longest has 2.3 kB, and devices with a hundred parts have about 1 kB for each."""


def excess_of(described: DeviceAnnounced, length: int) -> int:
    """Return by how many bytes *described* is longer than what its number of parts explains.

    Args:
        described: The description.
        length: Of the message that it alone was made of; 0 where many were, or the length is unknown: then only what
            the description shows counts, which is the lists, topics and facts.
    """
    shown = size_of_parts([one.part for one in described.parts])
    shown += size_of_texts(described.identifiers) + size_of_texts(described.facts.values())
    return max(0, max(length, shown) - _FREE - _FREE_PART * len(described.parts))


class Excess:
    """The account of what stands.

    Args:
        most: Bytes of all.
        most_each: Bytes of one.

    Attributes:
        total: Bytes of all that stand.
    """

    def __init__(self, most: int = MAX_EXCESS, most_each: int = MAX_EXCESS_EACH) -> None:
        self.total = 0
        self._most = most
        self._most_each = most_each

    def check(self, name: str, size: int, before: int) -> None:
        """Let one of *size* stand in place of one of the size *before*; one that is not longer always may.

        Raises:
            WireError: It is too long by itself, or one too many of the long ones.
        """
        if size <= before:
            return
        if size > self._most_each:
            raise WireError(
                f"{name!r} is {size:,} bytes longer than its parts explain; at most {self._most_each:,} are taken"
            )
        if self.total + size - before > self._most:
            raise WireError(
                f"{name!r} is {size:,} bytes longer than its parts explain, and there are long announcements of "
                f"{self.total:,} bytes already; withdraw some of them or shorten it"
            )
