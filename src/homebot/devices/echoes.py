"""A filter for events that arrive by several routes. Pure."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import final

from homebot.support.bounded_map import BoundedMap

WINDOW = 2.0
"""Seconds within which other routes report the same event."""

_MAX_EVENTS = 64
"""Most events remembered; the oldest is forgotten."""


@dataclass(slots=True)
class _RecentEvent:
    at: float
    count: int = 0
    by_route: dict[Hashable, int] = field(default_factory=dict)


@final
class Echoes:
    """Recent events that several routes tell, such as those of a button that two conventions announce.

    Of equal events within two seconds, as many happened as the route with the most reported.
    """

    __slots__ = ("_lately",)

    def __init__(self) -> None:
        self._lately: BoundedMap[Hashable, _RecentEvent] = BoundedMap(_MAX_EVENTS)

    def is_new(self, event: Hashable, route: Hashable, now: float) -> bool:
        """Return whether no other route has reported the event."""
        lately = self._lately.get(event)
        if lately is None or now - lately.at > WINDOW:
            lately = _RecentEvent(now)
        lately.at = now
        self._lately[event] = lately
        count = lately.by_route[route] = lately.by_route.get(route, 0) + 1
        if count <= lately.count:
            return False
        lately.count = count
        return True
