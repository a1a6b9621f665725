"""The plan of a house: rooms, doors and paths; also the sun and the weather outside."""

import heapq
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from homebot.errors import UsageError

DAY = 86_400.0
NOON_LUX = 100_000.0
"""A clear sky with the sun overhead."""


def daylight(now: float, first_day: int, latitude: float) -> float:
    """Return the lux outside under a clear sky: proportional to the sine of the sun's height, 0 at night.

    Args:
        now: Seconds since the midnight that begins the first day; local solar time.
        first_day: Day of the year of that day, 1 to 366.
        latitude: Degrees north.
    """
    day = first_day + now // DAY
    declination = math.radians(-23.44) * math.cos(math.tau * (day + 10) / 365.25)
    turned = math.tau * (now % DAY / DAY - 0.5)
    north = math.radians(latitude)
    height = math.sin(north) * math.sin(declination) + math.cos(north) * math.cos(declination) * math.cos(turned)
    return NOON_LUX * max(0.0, height)


def weather(now: float, first_day: int) -> float:
    """Return the degrees Celsius outside: warmest in late July and at three in the afternoon; arguments as above."""
    season = math.cos(math.tau * (first_day + now / DAY - 205) / 365.25)
    hour = math.cos(math.tau * (now % DAY / DAY - 15 / 24))
    return 10.0 + 10.0 * season + 4.0 * hour


class WorldTime(NamedTuple):
    """The relation of a world's time to that of the clock.

    Attributes:
        pace: Seconds of the world per second of the clock, above 0. It only applies to the world: messages, commands
            and apps run in real time.
        begins: The time of day, in seconds, at which the world starts; None for that of the clock, in UTC.
    """

    pace: float = 1.0
    begins: float | None = None

    @property
    def is_real(self) -> bool:
        """True if it is the time of the clock."""
        return self == REAL_TIME

    def first_midnight(self, now: float, lived: float) -> float:
        """Return the clock's time at the world's first midnight, if it is now and the world has run for *lived*."""
        time_of_day = now % DAY if self.begins is None else self.begins
        days = max(0, math.ceil((lived - time_of_day) / DAY))
        return now - time_of_day / self.pace - DAY * days / self.pace


REAL_TIME = WorldTime()
"""The time of the clock."""


OUTSIDE = "outside"
"""The room of absent people, with the light and temperature outside."""


DOOR_WIDTH = 0.9
"""Width of a door in metres."""


class Room(NamedTuple):
    """A room.

    Attributes:
        x: Its centre, in metres east.
        y: Its centre, in metres north.
        window: The share of daylight, 0 to 1, that enters.
        width: Its extent from west to east, in metres; 0 if unknown.
        depth: Its extent from south to north, likewise.
    """

    x: float = 0.0
    y: float = 0.0
    window: float = 0.01
    width: float = 0.0
    depth: float = 0.0

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Its corners, counter-clockwise; empty if its extent is unknown."""
        if not self.width or not self.depth:
            return ()
        left, right = self.x - self.width / 2, self.x + self.width / 2
        bottom, top = self.y - self.depth / 2, self.y + self.depth / 2
        return (left, bottom), (right, bottom), (right, top), (left, top)


@dataclass(frozen=True)
class Rooms:
    """Rooms by name, and the pairs joined by a door.

    Raises:
        UsageError: A door leads to an unknown room.
    """

    rooms: Mapping[str, Room]
    doors: Iterable[tuple[str, str]]
    _ways: dict[str, list[str]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        self._ways.update({name: [] for name in self.rooms})
        for door in self.doors:
            for here, there in (door, door[::-1]):
                if there not in self.rooms:
                    raise UsageError(f"a door leads to {there!r}, which is not a room")
                if here in self._ways and there not in self._ways[here]:
                    self._ways[here].append(there)
        for ways in self._ways.values():
            ways.sort()

    def room_at(self, x: float, y: float) -> str:
        """Return the room at a point; empty for none."""
        for name, room in self.rooms.items():
            if room.corners and abs(x - room.x) <= room.width / 2 and abs(y - room.y) <= room.depth / 2:
                return name
        return ""

    def doorways(self) -> Iterator[tuple[str, str, tuple[float, float]]]:
        """Yield two rooms with a door, and its centre: that of their shared wall."""
        for name, ways in self._ways.items():
            for other in ways:
                if name < other and (middle := _shared_wall(self.rooms[name], self.rooms[other])):
                    yield name, other, middle

    def path(self, start: str, goal: str) -> tuple[str, ...]:
        """Return the shortest path in rooms, both ends included; of equally short ones the first by name.

        Raises:
            UsageError: A room does not exist, or no door leads to it.
        """
        if start not in self.rooms or goal not in self.rooms:
            raise UsageError(f"there is no room {goal if start in self.rooms else start!r}")
        ahead: list[tuple[float, tuple[str, ...]]] = [(0.0, (start,))]
        seen: set[str] = set()
        while ahead:
            metres, way = heapq.heappop(ahead)
            if way[-1] == goal:
                return way
            if way[-1] in seen:
                continue
            seen.add(way[-1])
            for room in self._ways[way[-1]]:
                heapq.heappush(ahead, (metres + self.metres(way[-1], room), (*way, room)))
        raise UsageError(f"no doors lead from {start!r} to {goal!r}")

    def metres(self, here: str, there: str) -> float:
        """Return the distance between the centres of two rooms; at least 1 m."""
        room, other = self.rooms[here], self.rooms[there]
        return max(1.0, math.hypot(other.x - room.x, other.y - room.y))


def _shared_wall(room: Room, other: Room) -> tuple[float, float] | None:
    """Return the middle of the wall that two rooms share; None without one."""
    if not room.corners or not other.corners:
        return None
    (left, bottom), (right, top) = room.corners[0], room.corners[2]
    (left2, bottom2), (right2, top2) = other.corners[0], other.corners[2]
    low_x, high_x, low_y, high_y = max(left, left2), min(right, right2), max(bottom, bottom2), min(top, top2)
    touches = (low_x == high_x and low_y < high_y) or (low_y == high_y and low_x < high_x)
    return ((low_x + high_x) / 2, (low_y + high_y) / 2) if touches else None
