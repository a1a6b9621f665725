"""The ways through a house, and the sun and the weather around it."""

import pytest

from homebot.errors import UsageError
from homebot.house.rooms import DAY, Room, Rooms, daylight, weather

PLAN = {"a": Room(), "b": Room(x=3.0), "c": Room(x=3.0, y=4.0), "d": Room(x=30.0), "cellar": Room()}


def test_the_shortest_way_is_measured_in_metres() -> None:
    """Not in doors."""
    rooms = Rooms(PLAN, [("a", "b"), ("b", "c"), ("a", "d"), ("d", "c")])
    assert rooms.path("a", "c") == ("a", "b", "c")
    assert rooms.path("c", "a") == ("c", "b", "a")
    assert rooms.path("a", "a") == ("a",)
    assert rooms.metres("a", "c") == 5.0


def test_of_two_equally_short_ways_the_first_by_name_is_taken() -> None:
    """Whatever the order of the doors."""
    plan = {"start": Room(), "north": Room(y=3.0), "east": Room(x=3.0), "goal": Room(x=3.0, y=3.0)}
    doors = [("start", "north"), ("north", "goal"), ("start", "east"), ("east", "goal")]
    assert Rooms(plan, doors).path("start", "goal") == ("start", "east", "goal")
    assert Rooms(plan, doors[::-1]).path("start", "goal") == ("start", "east", "goal")


@pytest.mark.parametrize("goal", ["cellar", "attic"])
def test_where_no_doors_lead_there_is_no_way(goal: str) -> None:
    """Nor to a room that is not there."""
    with pytest.raises(UsageError, match=goal):
        Rooms(PLAN, [("a", "b")]).path("a", goal)


def test_a_door_to_nowhere_is_refused() -> None:
    """On either side."""
    with pytest.raises(UsageError, match="attic"):
        Rooms(PLAN, [("attic", "a")])


NOON = DAY / 2


def test_the_sun_is_highest_at_noon_and_down_at_midnight() -> None:
    """In the middle of Europe."""
    assert daylight(0.0, 80, 48.0) == 0.0
    assert daylight(NOON, 80, 48.0) == pytest.approx(67_000, rel=0.02)
    assert daylight(NOON - 3600, 80, 48.0) == pytest.approx(daylight(NOON + 3600, 80, 48.0))


@pytest.mark.parametrize(("latitude", "brighter", "darker"), [(48.0, 172, 355), (-48.0, 355, 172)])
def test_summer_is_brighter_on_either_half_of_the_globe(latitude: float, brighter: int, darker: int) -> None:
    """At opposite ends of the year."""
    assert daylight(NOON, brighter, latitude) > 2 * daylight(NOON, darker, latitude)


def test_the_sun_does_not_set_in_the_north_in_summer() -> None:
    """Nor rise in winter."""
    assert daylight(0.0, 172, 75.0) > 0.0
    assert daylight(NOON, 355, 75.0) == 0.0


def test_days_follow_the_first() -> None:
    """Ninety days after the winter solstice it is spring."""
    assert daylight(90 * DAY + NOON, 355, 48.0) == pytest.approx(daylight(NOON, 80, 48.0), rel=0.01)


def test_afternoons_and_summers_are_warm() -> None:
    """Nights and winters are not."""
    assert weather(15 * 3600.0, 205) == pytest.approx(24.0, abs=0.1)
    assert weather(3 * 3600.0, 22) == pytest.approx(-4.0, abs=0.1)
