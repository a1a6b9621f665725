"""The state of a device: the words of ``$state``. Pure.

Source: Homie convention 5, Device Lifecycle; Homie 4.0, Device Lifecycle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.description import Availability

__all__ = ["STATES", "StateTopic", "availability_of"]

STATES: Mapping[str, bool | None] = MappingProxyType(
    {"init": None, "ready": True, "sleeping": True, "alert": True, "disconnected": False, "lost": False}
)
"""Reachability of a device by its state; a sleeping one takes commands when it wakes, one that starts says neither."""


@dataclass(frozen=True, slots=True)
class StateTopic:
    """See :class:`homebot.conventions.description.AvailabilitySource`.

    Attributes:
        topic: The topic.
    """

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device can be reached, or None when *payload* says neither."""
        return STATES.get(payload.decode(errors="replace")) if len(payload) <= _LONGEST else None


_LONGEST = max(map(len, STATES))


def availability_of(topic: str, root: str) -> Availability:
    """Return how the device at *topic* tells whether it can be reached. One whose root is lost is lost.

    Args:
        topic: What its topics begin with.
        root: What those of its root begin with; empty where it has none.
    """
    return Availability(tuple(StateTopic(f"{one}/$state") for one in (topic, root) if one), "all")
