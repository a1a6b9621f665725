"""The floor of a simulated house, as places and as a map."""

from pathlib import Path

import pytest
from tests.whole_house import WHOLE_HOUSE

from homebot.house import World, thesis_world
from homebot.house.description import load_world
from homebot.house.rooms import Room, Rooms
from homebot.house.ros_robot import occupancy_grid
from homebot.messages.builtin_interfaces import Time
from homebot.places import FloorPlan, HousePlan, Places
from homebot.runtime.simulated_house import HouseOfRun


def test_the_places_of_the_small_house_are_valid_and_its_doors_are_at_their_rooms() -> None:
    world = thesis_world()
    places = HouseOfRun(world, (), "robot").places()
    plan = FloorPlan(HousePlan("home425", places.rooms, "the house", places.doors))
    assert {room.name for room in places.rooms} == {"Room 405", "Hall", "Room 165"}
    assert {one.rooms for one in places.doors} == {("Hall", "Room 405"), ("Hall", "Room 165")}
    for name, placed in world.devices.items():
        assert placed.at is not None, name
        found = plan.room_at(*placed.at)
        assert found is not None
        assert found.room == placed.room


@WHOLE_HOUSE
@pytest.mark.parametrize(("name", "doors"), [("flat", 2), ("family", 6), ("mixed", 3)])
def test_the_rooms_of_the_examples_stand_side_by_side_with_each_door_in_a_wall(name: str, doors: int) -> None:
    world = load_world(Path(__file__).parents[2] / "examples" / "houses" / f"{name}.toml")
    places = HouseOfRun(world, (), "robot").places()
    plan = FloorPlan(HousePlan("villa", places.rooms, name, places.doors))
    assert plan.overlaps == ()
    assert {room.name for room in places.rooms} == {*world.rooms.rooms} - {"outside"}
    assert len(places.doors) == doors


def test_a_house_without_extents_has_no_places() -> None:
    assert HouseOfRun(World(Rooms({"room": Room()}, []), ()), (), "robot").places() == Places()


def test_the_map_has_walls_with_a_door_in_them_and_the_row_in_front_is_the_southern_one() -> None:
    rooms = Rooms(
        {"hall": Room(width=2.0, depth=3.0), "kitchen": Room(x=2.0, width=2.0, depth=3.0)}, [("hall", "kitchen")]
    )
    grid = occupancy_grid(rooms, Time(sec=1, nanosec=0))
    info = grid.info
    assert (info.width, info.height, len(grid.data)) == (81, 61, 81 * 61)

    def cell(x: float, y: float) -> int:
        column = int((x - info.origin.position.x) / info.resolution)
        return int(grid.data[int((y - info.origin.position.y) / info.resolution) * info.width + column])

    assert [cell(0.0, 0.0), cell(2.0, 1.0)] == [0, 0]
    assert [cell(-1.0, 0.0), cell(3.0, 1.0), cell(0.5, 1.5), cell(2.5, -1.5)] == [100] * 4
    assert [cell(1.0, y) for y in (-1.0, -0.4, 0.0, 0.4, 1.0)] == [100, 0, 0, 0, 100]
    rooms = Rooms({"hall": Room(width=1.0, depth=1.0), "attic": Room(x=4.0, y=4.0, width=1.0, depth=1.0)}, [])
    assert occupancy_grid(rooms, Time(sec=1, nanosec=0)).data[-81 * 50] == -1
