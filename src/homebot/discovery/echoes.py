"""A filter for events that arrive by several routes. Pure."""

from dataclasses import dataclass, field
from typing import TypeAlias, final

from homebot.devices.value import PlainValue
from homebot.discovery.source_record import SourceKey
from homebot.support.bounded_map import BoundedMap

__all__ = ["Echoes"]

WINDOW = 2.0
"""Seconds within which other routes report the same event."""

_MOST = 64
"""Most events remembered per device; the oldest is forgotten."""

_Event: TypeAlias = tuple[int, str, PlainValue]


@dataclass(slots=True)
class _RecentEvent:
    at: float
    count: int = 0
    by_route: dict[SourceKey, int] = field(default_factory=dict)


@final
class Echoes:
    """The recent events of a device, such as a button that two conventions announce and that reports each press twice.

    Of equal events within two seconds, as many happened as the route with the most reported.
    """

    __slots__ = ("_lately",)

    def __init__(self) -> None:
        self._lately: BoundedMap[_Event, _RecentEvent] = BoundedMap(_MOST)

    def is_new(self, place: int, capability: str, value: PlainValue, route: SourceKey, now: float) -> bool:
        """Return whether no other route has reported the event."""
        what = (place, capability, value)
        lately = self._lately.get(what)
        if lately is None or now - lately.at > WINDOW:
            lately = _RecentEvent(now)
        lately.at = now
        self._lately[what] = lately
        count = lately.by_route[route] = lately.by_route.get(route, 0) + 1
        if count <= lately.count:
            return False
        lately.count = count
        return True
