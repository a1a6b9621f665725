"""The floor plan of a house: rooms at points, uncertain positions, doors, and ways."""

import json
import math
from pathlib import Path

import pytest

from homebot.errors import ConfigError
from homebot.places import FloorPlan, HouseDoor, HousePlan, HouseRoom, places_text, read_places
from homebot.places.floor_plan import RoomAt
from homebot.places.path import PathFinder, Spot
from homebot.places.polygon import Polygon
from homebot.support.toml_file import parse_toml

CASES = json.loads((Path(__file__).parent / "data" / "room_cases.json").read_text())

HOUSE = """\
[places.rooms.Hall]
polygon = [[0, 0], [4, 0], [4, 5], [0, 5]]

[places.rooms.Kitchen]
polygon = [[4, 0], [8, 0], [8, 5], [4, 5]]

[[places.doors]]
rooms = ["Hall", "Kitchen"]
position = [4, 4.5]
contact = "Kitchen door"
"""


POLYGON = "polygon = [[0, 0], [4, 0], [4, 5], [0, 5]]"


def house(text: str = HOUSE) -> HousePlan:
    places = parse_toml(text, "homebot.toml")["places"]
    assert isinstance(places, dict)
    read = read_places(places, "Home", "homebot.toml", "configuration")
    return HousePlan("Home", read.rooms, doors=read.doors)


def path_finder(plan: FloorPlan) -> PathFinder:
    steps = plan.path_finder()
    while True:
        try:
            next(steps)
        except StopIteration as done:
            finder: PathFinder = done.value
            return finder


@pytest.mark.parametrize("case", CASES["cases"], ids=lambda case: f"{case['x']},{case['y']}")
def test_rooms_of_a_configuration_are_found_by_point(case: dict[str, object]) -> None:
    tables = {name: [room["polygon"], *room.get("holes", ())] for name, room in CASES["rooms"].items()}
    rooms = read_places({"rooms": {name: {"polygon": one} for name, one in tables.items()}}, "Home", "x", "x").rooms
    found = FloorPlan.of(HousePlan("Home", rooms)).room_at(float(str(case["x"])), float(str(case["y"])))

    assert (found and found.room) == case["nearest"]
    assert (None if found is None or found.is_nearest else found.room) == case["room"]
    areas = [Polygon(room["polygon"], room.get("holes", ())) for room in CASES["rooms"].values()]
    distance = min(area.border_distance(float(str(case["x"])), float(str(case["y"]))) for area in areas)
    assert distance == pytest.approx(case["border_m"], abs=1e-6)


def test_a_wide_opening_is_passed_at_the_nearest_of_several_points() -> None:
    text = HOUSE.replace("position = [4, 4.5]", "position = [[4, 1], [4, 4]]")
    plan = FloorPlan.of(house(text))
    (doorway,) = map(plan.doorway, plan.plan.doors)

    assert sorted(round(first[1], 6) for first, _ in doorway.points) == [1.3, 1.9, 2.5, 3.1, 3.7]
    for first, second in doorway.points:
        assert first[0] == pytest.approx(3.999)
        assert second[0] == pytest.approx(4.001)


def test_a_door_between_two_floors_is_a_stair() -> None:
    rooms = HouseRoom("Hall", "Ground", ("Attic", "Bath")), HouseRoom("Attic", "Top"), HouseRoom("Bath", "Ground")
    plan = HousePlan("Home", rooms)
    floor_plan = FloorPlan.of(plan)

    costs = {one.rooms: floor_plan.cost_of(one) for one in plan.doors}

    assert costs == {("Hall", "Attic"): 10.0, ("Hall", "Bath"): 0.0}


@pytest.mark.parametrize(
    ("old", "new", "key", "reason"),
    [
        ("position = [4, 4.5]", "position = [4.4, 4.5]", "Kitchen.position", "0.40 m from Hall"),
        ('rooms = ["Hall", "Kitchen"]', 'rooms = ["Hall", "Kitchn"]', "Kitchn.rooms", "did you mean Kitchen"),
        ('rooms = ["Hall", "Kitchen"]', 'rooms = ["Hall"]', "places.doors", "rooms"),
        (POLYGON, "polygon = [[0, 0], [4, 5], [4, 0], [0, 5]]", "Hall.polygon", "cross"),
        (POLYGON, "polygon = [0, 4]", "Hall.polygon", "list of corners"),
    ],
)
def test_a_mistake_in_the_geometry_is_named_by_key_and_value(old: str, new: str, key: str, reason: str) -> None:
    text = HOUSE.replace(old, new)
    with pytest.raises(ConfigError) as caught:
        house(text)
    assert key in caught.value.key
    assert reason in str(caught.value)


def test_a_room_is_found_on_its_floor_alone() -> None:
    text = HOUSE.replace("[places.rooms.Kitchen]", '[places.rooms.Kitchen]\nfloor = "Top"')
    plan = FloorPlan.of(house(text))

    assert plan.room_at(5, 1) is None
    assert plan.room_at(5, 1, "top") == RoomAt("Kitchen")


def test_a_robot_enters_a_room_inside_another_one() -> None:
    niche = "[places.rooms.Niche]\npolygon = [[1, 1], [3, 1], [3, 3], [1, 3]]\n\n"
    plan = FloorPlan.of(house(niche + HOUSE))

    rooms, last = [], ""
    for x in (0.5, 1.1, 1.3, 1.1, 0.9, 0.7):
        found = plan.room_at(x, 2, last=last)
        assert found is not None
        last = found.room
        rooms.append(last)

    assert rooms == ["Hall", "Hall", "Niche", "Niche", "Niche", "Hall"]


def test_stairs_have_a_foot_and_a_head() -> None:
    text = HOUSE.replace("[places.rooms.Kitchen]", '[places.rooms.Kitchen]\nfloor = "Top"')
    plan = FloorPlan.of(house(text.replace("position = [4, 4.5]", "position = [[1, 4.8], [7, 0.2]]")))
    finder = path_finder(plan)
    finder.put("lamp", Spot("Kitchen", (7.0, 4.2)))

    (way,) = finder.nearest(Spot("Hall", (1.0, 1.8)), lambda _: 10.0)

    assert (round(way.path, 2), way.extra) == (7.0, 10.0)
    with pytest.raises(ConfigError, match=r"2\.00 m from Kitchen"):
        house(text.replace("position = [4, 4.5]", "position = [[1, 4.8], [10, 0.2]]"))


def test_a_way_in_a_room_of_two_areas_leads_through_both() -> None:
    """Two rectangles form an L, once by touching and once by overlapping; across the corner is outside."""
    for upper in ([[0, 2], [2, 2], [2, 6], [0, 6]], [[0, 0], [2, 0], [2, 6], [0, 6]]):
        polygon = [[[[0, 0], [6, 0], [6, 2], [0, 2]]], [upper]]
        plan = FloorPlan.of(house(HOUSE + f"\n[places.rooms.L]\nfloor = 'Top'\npolygon = {polygon}\n"))
        finder = path_finder(plan)
        finder.put("lamp", Spot("L", (1.0, 5.0)))

        (way,) = finder.nearest(Spot("L", (5.0, 1.0)), lambda _: 0.0)

        assert way.path == pytest.approx(math.dist((5, 1), (2, 2)) + math.dist((2, 2), (1, 5)))


def test_rooms_that_overlap_are_named_and_nested_ones_are_not() -> None:
    rooms = {"Hall": (0, 0, 4, 4), "Kitchen": (3.5, 1, 8, 3), "Niche": (1, 1, 2, 2), "Bath": (4, 3, 5, 4)}
    table = {name: {"polygon": [[a, b], [c, b], [c, d], [a, d]]} for name, (a, b, c, d) in rooms.items()}
    plan = HousePlan("Home", read_places({"rooms": table}, "Home", "x", "x").rooms)

    assert [(a, b, round(area, 6)) for a, b, area in FloorPlan.of(plan).overlaps] == [("Hall", "Kitchen", 1.0)]


def test_a_written_plan_is_read_as_it_was() -> None:
    ring = ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0))
    hole = ((1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0))
    far = tuple((x + 20, y) for x, y in ring)
    rooms = (
        HouseRoom("Hall", "Ground", polygons=((ring,),)),
        HouseRoom("Ring", "Top", polygons=((ring, hole),)),
        HouseRoom("Two", "Top", polygons=((ring,), (far,))),
    )
    doors = (HouseDoor("Stairs", ("Hall", "Ring"), ((9.0, 1.0),), 1.1, "a contact", "a lock", 12.5),)
    plan = HousePlan("Home", rooms, doors=doors)

    read = house(places_text(plan))

    assert read.rooms == plan.rooms
    assert read.doors == plan.doors
