"""People have habits and walk from room to room, and whoever watches is told."""

from collections.abc import Callable

import pytest

from homebot.errors import UsageError
from homebot.house.household import Habit, Household, Person, Visit
from homebot.house.rooms import DAY, Room, Rooms
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


ANNA = Person("anna", [Habit(80_000.0, "bed", asleep=True), Habit(30_000.0, "kitchen", jitter=600.0)])


def test_a_plan_is_in_time_order_and_on_its_day() -> None:
    """Whatever the order of the habits."""
    breakfast, bed = ANNA.plan(2, "1")
    assert (breakfast.room, bed) == ("kitchen", Visit(2 * DAY + 80_000.0, "bed", asleep=True))


def test_jitter_differs_from_day_to_day_and_seed_to_seed_within_its_bounds() -> None:
    """And is the same for the same."""
    drawn = {ANNA.plan(day, seed)[0].at - day * DAY for day in range(20) for seed in ("1", "2")}
    assert len(drawn) == 40
    assert all(29_400.0 <= at <= 30_600.0 for at in drawn)
    assert ANNA.plan(3, "1") == ANNA.plan(3, "1")


def test_no_jitter_leads_out_of_the_day() -> None:
    """Midnight is the limit."""
    owl = Person("owl", [Habit(0.0, "kitchen", jitter=600.0), Habit(86_399.0, "hall", jitter=600.0)])
    for day in range(20):
        assert all(day * DAY <= visit.at < (day + 1) * DAY for visit in owl.plan(day, "1"))
