"""The floor plan of a house: rooms at points, uncertain positions, doors, and ways."""

from __future__ import annotations

import json
import math
from pathlib import Path
from random import Random

import pytest

from homebot.errors import ConfigError
from homebot.places import FloorPlan, HouseDoor, HousePlan, HouseRoom, Position, places_text, read_places
from homebot.places.path import Spot
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


@pytest.mark.parametrize("case", CASES["cases"], ids=lambda case: f"{case['x']},{case['y']}")
def test_rooms_of_a_configuration_are_found_by_point(case: dict[str, object]) -> None:
    tables = {name: [room["polygon"], *room.get("holes", ())] for name, room in CASES["rooms"].items()}
    rooms = read_places({"rooms": {name: {"polygon": one} for name, one in tables.items()}}, "Home", "x", "x").rooms
    found = FloorPlan.of(HousePlan("Home", rooms)).room_at(float(str(case["x"])), float(str(case["y"])))

    assert (found and found.room) == case["nearest"]
    assert (found is not None and not found.is_nearest) is (case["room"] is not None)


def test_the_lamp_behind_the_wall_is_farther_in_a_configured_house() -> None:
    plan = FloorPlan.of(house())
    finder = plan.path_finder()
    for name, position in (("kitchen lamp", Position(4.5, 1)), ("hall lamp", Position(1, 1))):
        place = plan.place_of(position)
        assert place is not None
        finder.put(name, place)

    routes = list(finder.nearest(Spot("Hall", (3.5, 1.0)), lambda _: 3.0))

    assert [(one.target, round(one.path + one.extra, 2)) for one in routes] == [
        ("hall lamp", 2.5),
        ("kitchen lamp", 10.07),
    ]
    assert routes[1].doors == ("Hall–Kitchen",)  # noqa: RUF001 - as it is named


def test_a_wide_opening_is_passed_at_the_nearest_of_several_points() -> None:
    text = HOUSE.replace("position = [4, 4.5]", "position = [[4, 1], [4, 4]]")
    (doorway,) = FloorPlan.of(house(text)).doorways()

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
        (
            'rooms = ["Hall", "Kitchen"]',
            'rooms = ["Hall", "Kitchn"]',
            "Kitchn.rooms",
            "did you mean Kitchen",
        ),
        ('rooms = ["Hall", "Kitchen"]', 'rooms = ["Hall"]', "places.doors", "rooms"),
        (
            POLYGON,
            "polygon = [[0, 0], [4, 5], [4, 0], [0, 5]]",
            "Hall.polygon",
            "cross",
        ),
        (
            POLYGON,
            "polygon = [[0, 0], [4, 0]]",
            "Hall.polygon",
            "2 different corners",
        ),
        (POLYGON, "polygon = [0, 4]", "Hall.polygon", "list of corners"),
        (
            POLYGON,
            "polygon = [[0, 0], [nan, 0], [1, 1]]",
            "Hall.polygon",
            "10,000 m",
        ),
    ],
)
def test_a_mistake_in_the_geometry_is_named_by_key_and_value(old: str, new: str, key: str, reason: str) -> None:
    text = HOUSE.replace(old, new)
    with pytest.raises(ConfigError) as caught:
        house(text)
    assert key in caught.value.key
    assert reason in str(caught.value)


def test_a_robot_in_a_doorway_stays_in_its_room_until_it_is_well_outside() -> None:
    plan = FloorPlan.of(house())

    rooms, last = [], ""
    for x in (3.9, 4.05, 3.95, 4.15, 4.25, 4.1, 3.85, 3.75):
        found = plan.room_at(x, 4.5, last=last)
        assert found is not None
        last = found.room
        rooms.append(last)

    assert rooms == ["Hall", "Hall", "Hall", "Hall", "Kitchen", "Kitchen", "Kitchen", "Hall"]


def test_the_rooms_of_an_uncertain_position_are_as_likely_as_many_random_points_say() -> None:
    plan, random = FloorPlan.of(house()), Random(7)  # noqa: S311 - a test that repeats
    for _ in range(25):
        x, y = random.uniform(2, 6), random.uniform(0.5, 4.5)
        spread, ratio, angle = random.uniform(0.05, 0.8), random.uniform(0.3, 1), random.uniform(0, math.pi)
        major, minor = spread**2, (spread * ratio) ** 2
        c, s = math.cos(angle), math.sin(angle)
        covariance = [0.0] * 36
        covariance[0], covariance[7] = major * c * c + minor * s * s, major * s * s + minor * c * c
        covariance[1] = covariance[6] = (major - minor) * s * c
        drawn: dict[str, int] = {}
        for _ in range(4000):
            u, v = random.gauss(0, spread), random.gauss(0, spread * ratio)
            at = plan.room_at(x + u * c - v * s, y + u * s + v * c)
            drawn[at.room if at else ""] = drawn.get(at.room if at else "", 0) + 1

        found = dict(plan.rooms_of(x, y, covariance))

        assert sum(found.values()) == pytest.approx(1)
        for room in {*drawn, *found}:
            assert found.get(room, 0) == pytest.approx(drawn.get(room, 0) / 4000, abs=0.06)


def test_rooms_that_overlap_are_named_and_nested_ones_are_not() -> None:
    rooms = {"Hall": (0, 0, 4, 4), "Kitchen": (3.5, 1, 8, 3), "Niche": (1, 1, 2, 2), "Bath": (4, 3, 5, 4)}
    table = {name: {"polygon": [[a, b], [c, b], [c, d], [a, d]]} for name, (a, b, c, d) in rooms.items()}
    plan = HousePlan("Home", read_places({"rooms": table}, "Home", "x", "x").rooms)

    assert [(a, b, round(area, 6)) for a, b, area in FloorPlan.of(plan).overlaps()] == [("Hall", "Kitchen", 1.0)]


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
