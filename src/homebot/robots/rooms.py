"""The rooms of the house, found by the positions of robots. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from homebot.places.floor_plan import FloorPlan, RoomAt
from homebot.places.plan import HousePlan, HouseRoom
from homebot.robots.evidence import ROOM_ERROR, MapPose

__all__ = ["RobotRooms"]


@final
class RobotRooms:
    """The rooms of the house, and those on the maps of robots of which the house states no area.

    Args:
        house: The plan of the house.

    Attributes:
        house: Likewise.
    """

    def __init__(self, house: HousePlan) -> None:
        self.house = house
        self._by_map: dict[str, tuple[HouseRoom, ...]] = {}
        self._floor_plan = FloorPlan.of(house)

    def set_house(self, house: HousePlan) -> None:
        """Take *house* in place of the plan before.

        Raises:
            ConfigError: The rooms on the maps of robots do not fit it.
        """
        self.house = house
        self._join()

    def set_map(self, robot: str, rooms: Iterable[HouseRoom]) -> None:
        """Take *rooms* in place of those on the map of *robot* before.

        Raises:
            ConfigError: They do not fit the house; they are left out.
        """
        self._by_map[robot] = tuple(rooms)
        try:
            self._join()
        except Exception:
            del self._by_map[robot]
            raise

    def floor_of(self, stated: str) -> str:
        """Return the floor *stated*, or the only one that has areas."""
        return self._floor_plan.level(stated)

    def room_at(self, at: MapPose, floor: str, before: str) -> RoomAt | None:
        """Return the room at a position on *floor*: that of *before*, until the robot is 0.2 m out of it."""
        return self._floor_plan.room_at(at.x, at.y, floor, before)

    def error_in(self, room: str) -> float:
        """Return by how many metres a position may be wrong of which only the room is known."""
        centre = self._floor_plan.centre_of(room)
        return ROOM_ERROR if centre is None else centre.error

    def _join(self) -> None:
        mapped = (room for rooms in self._by_map.values() for room in rooms)
        plan = HousePlan(self.house.home, (*mapped, *self.house.rooms), "a map of a robot", self.house.doors)
        self._floor_plan = FloorPlan.of(plan)
