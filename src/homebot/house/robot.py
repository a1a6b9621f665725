"""A robot that drives through the house."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from homebot.errors import UsageError
from homebot.house.rooms import Rooms
from homebot.house.simulated_device import SimulatedDevice

__all__ = ["Robot", "RobotPose"]


class RobotPose(NamedTuple):
    """A position and the direction of view.

    Attributes:
        x: Metres east.
        y: Metres north.
        heading: Radians from east, counter-clockwise.
    """

    x: float
    y: float
    heading: float


@dataclass(eq=False)
class Robot(SimulatedDevice):
    """A robot that takes ``go ROOM`` and ``stop``, and reports each room that it enters.

    It drives from the middle of one room to the middle of the next, at one speed. A room that no doors lead to it
    ignores. Stopped between two rooms it drives on to the nearer one's middle only when told.

    Attributes:
        rooms: The plan it has.
        room: The last room with a reached middle.
        speed: Metres a second, above 0.
    """

    kind: ClassVar[str] = "robot"
    rooms: Rooms = field(repr=False)
    room: str
    speed: float = 0.5
    service_type: str = field(default="robots", kw_only=True)

    def __post_init__(self) -> None:
        start = self.rooms.rooms[self.room]
        self._from = self._at_rest = RobotPose(start.x, start.y, 0.0)
        self._left_at = self.now
        self._ahead: tuple[str, ...] = ()

    def state(self) -> str:
        """Return the room it is in, or ``moving``."""
        return "moving" if self.drives else self.room

    def restore(self) -> str:
        """Return ``go`` to the room it is in."""
        return f"go {self.room}"

    @property
    def drives(self) -> bool:
        """True while it is on its way."""
        return bool(self._ahead)

    def pose(self) -> RobotPose:
        """Return where it is at :attr:`now`."""
        if not self._ahead:
            return self._at_rest
        goal = self.rooms.rooms[self._ahead[0]]
        share = (self.now - self._left_at) / self._leg()
        heading = math.atan2(goal.y - self._from.y, goal.x - self._from.x)
        return RobotPose(
            self._from.x + (goal.x - self._from.x) * share, self._from.y + (goal.y - self._from.y) * share, heading
        )

    def next_event(self) -> float | None:
        """Return when it reaches the next room."""
        return self._left_at + self._leg() if self._ahead else None

    def commands(self) -> tuple[str, ...]:
        """Return the commands that it knows."""
        return ("stop", *(f"go {room}" for room in self.rooms.rooms if self._way_to(room)))

    def knows(self, command: str) -> bool:
        """Return whether it knows *command*; a room that no doors lead to it does not."""
        return command == "stop" or (command.startswith("go ") and bool(self._way_to(command.removeprefix("go "))))

    def _obey(self, command: str) -> tuple[str, ...]:
        if command == "stop":
            self._at_rest, self._ahead = self.pose(), ()
            return (self.state(),)
        way = self._way_to(command.removeprefix("go ")) if command.startswith("go ") else ()
        if not way:
            return ()
        pose, here = self.pose(), self.rooms.rooms[self.room]
        is_there = (pose.x, pose.y) == (here.x, here.y)
        self._from, self._left_at, self._ahead = pose, self.now, way[1:] if is_there else way
        return (self.state(),)

    def _way_to(self, room: str) -> tuple[str, ...]:
        """Return the rooms on the way, with both ends; empty where there is none."""
        try:
            return self.rooms.path(self.room, room)
        except UsageError:
            return ()

    def _on_timer(self) -> tuple[str, ...]:
        heading = self.pose().heading
        self._left_at += self._leg()
        self.room, self._ahead = self._ahead[0], self._ahead[1:]
        place = self.rooms.rooms[self.room]
        self._from = self._at_rest = RobotPose(place.x, place.y, heading)
        return (self.room,)

    def _leg(self) -> float:
        """Return seconds from where it set out to the next room."""
        goal = self.rooms.rooms[self._ahead[0]]
        return max(0.01, math.hypot(goal.x - self._from.x, goal.y - self._from.y) / self.speed)
