"""A robot that drives through the house."""

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from homebot.errors import UsageError
from homebot.house.rooms import Rooms
from homebot.house.simulated_device import Drive, SimulatedDevice
from homebot.places import read_position
from homebot.places.plan import Point
from homebot.places.rigid import MapPose


class _Leg(NamedTuple):
    """A straight piece of a path: its end, and the room there."""

    room: str
    x: float
    y: float


@dataclass(eq=False)
class Robot(SimulatedDevice):
    """A robot that takes ``go ROOM``, ``go X,Y`` and ``stop``, and reports each room that it enters.

    It drives at constant speed from the middle of one room to the middle of the next, and finally to a point in a room.
    It ignores rooms to which no doors lead. If stopped between two rooms, it stays there until the next command.

    Attributes:
        room: The last room whose middle it has reached.
        speed: Metres a second, above 0.
    """

    kind: ClassVar[str] = "robot"
    stays: ClassVar[bool] = False
    rooms: Rooms = field(repr=False)
    room: str
    speed: float = 0.5
    service_type: str = field(default="robots", kw_only=True)

    def __post_init__(self) -> None:
        start = self.rooms.rooms[self.room]
        self._from = self._at_rest = MapPose(start.x, start.y, 0.0)
        self._left_at = self.now
        self._ahead: tuple[_Leg, ...] = ()

    def state(self) -> str:
        """Return its room, or ``moving``."""
        return "moving" if self.drives else self.room

    def restore(self) -> str:
        """Return ``go`` to its room."""
        return f"go {self.room}"

    @property
    def drives(self) -> bool:
        """True while it drives."""
        return bool(self._ahead)

    @property
    def drive(self) -> Drive:
        """Its drive."""
        return Drive(self.room, self.drives)

    def pose(self) -> MapPose:
        """Return its pose at :attr:`now`."""
        if not self._ahead:
            return self._at_rest
        goal = self._ahead[0]
        share = (self.now - self._left_at) / self._leg()
        heading = math.atan2(goal.y - self._from.y, goal.x - self._from.x)
        return MapPose(
            self._from.x + (goal.x - self._from.x) * share, self._from.y + (goal.y - self._from.y) * share, heading
        )

    def way(self) -> tuple[Point, ...]:
        """Return the points that it drives to, in their order; none while it stands."""
        return tuple(leg[1:] for leg in self._ahead)

    def heads_for(self, point: Point) -> bool:
        """Return whether it drives to *point*, or stands there."""
        return (self._ahead[-1][1:] if self._ahead else self.pose()[:2]) == point

    def metres_left(self) -> float:
        """Return the length of the remaining path."""
        here, metres = self.pose()[:2], 0.0
        for leg in self._ahead:
            metres += math.dist(here, leg[1:])
            here = leg[1:]
        return metres

    def next_event(self) -> float | None:
        """Return when it reaches the next room."""
        return self._left_at + self._leg() if self._ahead else None

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return ("stop", *(f"go {room}" for room in self.rooms.rooms if self._way_to(room)))

    def knows(self, command: str) -> bool:
        """Return whether it knows *command*; not for rooms to which no doors lead."""
        return command == "stop" or (command.startswith("go ") and bool(self._legs_to(command.removeprefix("go "))))

    def _obey(self, command: str) -> tuple[str, ...]:
        if command == "stop":
            self._at_rest, self._ahead = self.pose(), ()
            return (self.state(),)
        legs = self._legs_to(command.removeprefix("go ")) if command.startswith("go ") else ()
        if not legs:
            return ()
        self._from, self._left_at, self._ahead = self.pose(), self.now, legs
        if self._from[:2] == legs[0][1:]:
            self._ahead = legs[1:]
        return (self.state(),)

    def _legs_to(self, goal: str) -> tuple[_Leg, ...]:
        """Return the path to a room, or to a point in one; empty if there is none."""
        try:
            point = read_position(goal)[:2]
        except UsageError:
            point = None
        room = goal if point is None else self.rooms.room_at(*point)
        way = self._way_to(room) if room else ()
        legs = tuple(_Leg(room_name, self.rooms.rooms[room_name].x, self.rooms.rooms[room_name].y) for room_name in way)
        if point is None or not legs:
            return legs
        is_there = room == self.room == self.rooms.room_at(*self.pose()[:2])
        return (*(() if is_there else legs), _Leg(room, *point))

    def _way_to(self, room: str) -> tuple[str, ...]:
        """Return the rooms on the path, both ends included; empty if there is none."""
        try:
            return self.rooms.path(self.room, room)
        except UsageError:
            return ()

    def _on_timer(self) -> tuple[str, ...]:
        heading = self.pose().yaw
        self._left_at += self._leg()
        leg, self._ahead = self._ahead[0], self._ahead[1:]
        self.room = leg.room
        self._from = self._at_rest = MapPose(leg.x, leg.y, heading)
        return (self.room,)

    def _leg(self) -> float:
        """Return the seconds from its start to the next room."""
        goal = self._ahead[0]
        return max(0.01, math.hypot(goal.x - self._from.x, goal.y - self._from.y) / self.speed)
