"""The areas of a house are nested, and its doors have two ends."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import ConfigError
from homebot.places import HousePlan, HouseRoom
from homebot.support.folding import fold

HOUSE = (
    HouseRoom("Hall", "Downstairs", ("Kitchen", "outside")),
    HouseRoom("Kitchen", "downstairs"),
    HouseRoom("Bed room", "Upstairs", ("hall",)),
)
NAMES = st.sampled_from(["Hall", "hall", "Kitchen", "Attic", "Upstairs", "upstairs", "Home", "outside"])
FLOORS = st.one_of(st.just(""), NAMES)
ROOMS = st.lists(
    st.builds(HouseRoom, NAMES, FLOORS, st.lists(NAMES, max_size=2).map(tuple), st.just(())),
)


def test_a_room_is_on_its_floor_and_in_the_home() -> None:
    plan = HousePlan("Home", HOUSE)
    assert plan.locate("kitchen") == ("Kitchen", ("Downstairs", "Home"))
    assert plan.locate("BED-ROOM") == ("Bed room", ("Upstairs", "Home"))
    assert plan.locate("upstairs") == ("Upstairs", ("Home",))
    assert plan.locate("home") == ("Home", ())
    assert plan.locate("Cellar") == ("Cellar", ("Home",))
    assert plan.floors == ("Downstairs", "Upstairs")


@pytest.mark.parametrize(
    ("room", "floor", "located"),
    [
        ("Cellar", "Below", ("Cellar", ("Below", "Home"))),
        ("Attic", "upstairs", ("Attic", ("Upstairs", "Home"))),
        ("kitchen", "Upstairs", ("Kitchen", ("Downstairs", "Home"))),
        ("Attic", "hall", ("Attic", ("Home",))),
        ("Attic", "Outside", ("Attic", ("Home",))),
        ("Attic", "HOME", ("Attic", ("Home",))),
        ("Attic", "", ("Attic", ("Home",))),
        ("Cellar", "cellar", ("Cellar", ("Home",))),
        ("upstairs", "Top", ("Upstairs", ("Home",))),
        ("home", "Top", ("Home", ())),
    ],
)
def test_an_announced_floor_counts_where_the_plan_states_none(
    room: str, floor: str, located: tuple[str, tuple[str, ...]]
) -> None:
    plan = HousePlan("Home", (*HOUSE, HouseRoom("Attic")))
    assert plan.locate_on(room, floor) == located


def test_a_door_that_is_stated_at_one_end_is_at_both() -> None:
    plan = HousePlan("Home", HOUSE)
    assert {room.name: room.doors for room in plan.rooms} == {
        "Hall": ("Kitchen", "outside", "Bed room"),
        "Kitchen": ("Hall",),
        "Bed room": ("Hall",),
    }
    assert plan.room("HALL") == plan.rooms[0]
    assert plan.room("Cellar") is None


def test_further_rooms_add_doors_and_a_later_floor_wins() -> None:
    plan = HousePlan("Home", HOUSE).with_rooms((HouseRoom("kitchen", "Cellar", ("Bed room",)),), "a file")
    assert plan.room("Kitchen") == HouseRoom("Kitchen", "Cellar", ("Hall", "Bed room"))
    assert plan.room("Hall") == HouseRoom("Hall", "Downstairs", ("Kitchen", "outside", "Bed room"))


@pytest.mark.parametrize(
    ("rooms", "key", "reason"),
    [
        ((HouseRoom("Hall", "Kitchen"), HouseRoom("kitchen")), "places.rooms.Hall.floor", "'Kitchen' is a room"),
        ((HouseRoom("Hall", "hall"),), "places.rooms.Hall.floor", "'hall' is a room"),
        ((HouseRoom("Hall", "home"),), "places.rooms.Hall.floor", "'home' is the name of the home"),
        ((HouseRoom("HOME"),), "places.rooms.HOME", "is the name of the home"),
        ((HouseRoom("Hall", "Outside"),), "places.rooms.Hall.floor", "'Outside' is a room"),
        (
            (HouseRoom("Hall", "", ("Kichen",)), HouseRoom("Kitchen")),
            "places.rooms.Hall.doors",
            "did you mean Kitchen?",
        ),
        ((HouseRoom("Hall", "", ("hall",)),), "places.rooms.Hall.doors", "'Hall' is the room itself"),
        (tuple(HouseRoom(f"Room {one}") for one in range(1001)), "places.rooms", "1,000 is the limit"),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_a_plan_that_cannot_be_is_refused_by_key_and_value(rooms: tuple[HouseRoom, ...], key: str, reason: str) -> None:
    with pytest.raises(ConfigError) as refused:
        HousePlan("Home", rooms, "homebot.toml")
    assert (refused.value.source, refused.value.key) == ("homebot.toml", key)
    assert reason in refused.value.reason


@given(st.lists(ROOMS, max_size=3), NAMES)
def test_no_area_is_in_itself_however_plans_are_joined(plans: list[list[HouseRoom]], name: str) -> None:
    plan = HousePlan("Home")
    for rooms in plans:
        try:
            plan = plan.with_rooms(rooms, "a file")
        except ConfigError:
            continue
    area, outer = plan.locate(name)
    levels = [fold(one) for one in (area, *outer)]
    assert len(set(levels)) == len(levels)
    assert levels[-1] == "home"
    for inner, one in pairwise(outer):
        assert plan.locate(inner) == (inner, tuple(outer[outer.index(one) :]))


@given(ROOMS)
def test_a_door_leads_back(rooms: list[HouseRoom]) -> None:
    try:
        plan = HousePlan("Home", rooms)
    except ConfigError:
        return
    for room in plan.rooms:
        for door in room.doors:
            other = plan.room(door)
            assert fold(door) == "outside" if other is None else room.name in other.doors
