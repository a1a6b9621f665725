"""The ways through a house."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.house.rooms import Room, Rooms

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
