"""People walk from room to room, and whoever watches is told."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from homebot.errors import UsageError
from homebot.house.household import Habit, Household, Person
from homebot.house.rooms import Room, Rooms
from homebot.support.timer_queue import TimerQueue

PLAN = Rooms({"a": Room(), "b": Room(x=3.0), "c": Room(x=5.0), "loft": Room()}, [("a", "b"), ("b", "c")])


class Watch:
    """Writes down what it is told, and keeps the time."""

    def __init__(self) -> None:
        self.now = 0.0
        self.seen: list[tuple[float, str]] = []

    def on_door_passed(self, name: str, left: str, entered: str) -> None:
        self.seen.append((self.now, f"{name} {left}-{entered}"))

    def on_sleep(self, name: str, room: str) -> None:
        self.seen.append((self.now, f"{name} sleeps in {room}"))

    def on_motion(self, room: str) -> None:
        self.seen.append((self.now, room))

    def on_still(self, room: str) -> None:
        self.seen.append((self.now, f"still in {room}"))


def lived(watch: Watch, *people: Person) -> Household:
    """A day of *people*."""
    queue: TimerQueue[object, Callable[[], None]] = TimerQueue()
    household = Household(people, PLAN, queue, lambda: watch.now, watch)
    household.begin_day(0, "seed")
    while (at := queue.next()) is not None:
        watch.now = at
        due = queue.pop()
        assert due is not None
        due[1]()
    return household


def test_a_way_takes_its_time_and_every_room_on_it_stirs() -> None:
    """Two metres a second; the room that was left and the one that was entered."""
    watch = Watch()
    household = lived(watch, Person("anna", [Habit(10.0, "c", asleep=True)], "a", speed=2.0))
    assert watch.seen == [
        (10.0, "a"),
        (11.5, "anna a-b"),
        (11.5, "a"),
        (11.5, "b"),
        (12.5, "anna b-c"),
        (12.5, "b"),
        (12.5, "anna sleeps in c"),
        (12.5, "c"),
    ]
    assert (household.people_in("c"), household.awake_in("c"), household.people_in("a")) == (("anna",), 0, ())


def test_a_newer_way_ends_an_older_one() -> None:
    """From the room where they are."""
    watch = Watch()
    household = lived(watch, Person("anna", [Habit(10.0, "c"), Habit(14.0, "a")], "a"))
    assert [what for _, what in watch.seen if " " in what] == ["anna a-b", "anna b-a"]
    assert household.awake_in("a") == 1


@pytest.mark.parametrize("room", ["attic", "loft"])
def test_a_habit_that_cannot_be_is_refused(room: str) -> None:
    """No such room, or no doors to it."""
    with pytest.raises(UsageError, match=room):
        lived(Watch(), Person("anna", [Habit(10.0, room)], "a"))
