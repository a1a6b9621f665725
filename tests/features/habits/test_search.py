"""Habits of a simulated family are found, and nothing else is taken for one."""

from collections.abc import Iterator
from random import Random

import pytest
from tests.features.habits.family import HABITS, Family, Planted, days_of, sun_is_down
from tests.sizes import size

from homebot.features.habits.days import DAY, Days, Happening
from homebot.features.habits.habit import FoundHabit, wilson_lower_bound
from homebot.features.habits.search import find_habits

SEEDS = range(size(3, 20))
HOLIDAYS = range(9, 12)
GUESTS = range(16, 18)
BLIND = HABITS[4]


def found_in(days: Days) -> list[FoundHabit]:
    return [one for one in find_habits(days) if one is not None]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_habits_of_a_family_are_found_in_three_weeks(seed: int) -> None:
    """With holidays, in which nothing happens, guests, and a habit that changes after the first ten days."""
    family = Family(seed, holidays=HOLIDAYS, guests=GUESTS)
    family.changed = (10, BLIND, Planted("21.5", BLIND.do))
    habits = found_in(family.days(21))
    assert len({one.do for one in habits} & {one.do for one in HABITS}) >= 11
    assert {one.when for one in habits if one.do == BLIND.do} <= {"21:20", "21:25", "21:30", "21:35", "21:40"}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("bustle", [1, 2])
def test_no_habit_is_found_where_there_is_none(seed: int, bustle: int) -> None:
    """Each fortnight, as those see it who ask again and again: the fewest days have the most p_value."""
    events = Family(seed, habits=(), bustle=bustle).days(100).events
    fortnights = [days_of([one for one in events if first <= one.at / DAY < first + 14]) for first in range(0, 98, 14)]
    assert len([one for days in fortnights for one in found_in(days)]) <= 1


def test_the_lamp_of_a_bound_button_is_nobodys_habit() -> None:
    """Its lamp says a second later that it is on, and the journal takes that for a hand."""
    bound = Planted("hall button single pressed", "office lamp on", late=1.8)
    habits = found_in(Family(1, habits=(bound, *HABITS[:5])).days(21))
    assert HABITS[0].do in {one.do for one in habits}
    assert not [one for one in habits if one.when == bound.when]


def test_what_follows_after_always_the_same_minute_is_nobodys_habit() -> None:
    """A fan that follows its lamp says so by itself, and the journal may take that for a hand."""
    events = Family(1).days(21).events
    fan = [Happening(one.at + 60, "fan", "on_off", "fan on", "fan on") for one in events if one.text == "tv on"]
    fan += [Happening(one.at + 600, "fan", "on_off", "fan off") for one in fan]
    habits = found_in(days_of(sorted([*events, *fan], key=lambda one: one.at)))
    assert HABITS[0].do in {habit.do for habit in habits}
    assert "fan on" not in {habit.do for habit in habits}


def test_a_habit_has_its_conditions_and_every_occasion() -> None:
    days = Family(1, holidays=HOLIDAYS).days(21)
    (hall,) = (one for one in found_in(days) if one.do == "hall lamp on")
    assert (hall.when, hall.conditions, hall.within) == ("hall motion occupied", ("sun is down",), 60.0)
    assert hall.done >= 0.8 * len(hall.occasions)
    for one in hall.occasions:
        assert sun_is_down(one.at)
        assert one.done_at is None or 0 < one.done_at - one.at <= 60


@pytest.mark.parametrize(("done", "of", "share"), [(0, 0, 0.0), (5, 5, 0.649), (14, 15, 0.749), (50, 100, 0.419)])
def test_the_sure_share_is_the_bound_of_wilson(done: int, of: int, share: float) -> None:
    assert wilson_lower_bound(done, of) == pytest.approx(share, abs=0.001)


def test_a_habit_after_dark_is_found_though_its_trigger_comes_all_day() -> None:
    """Motion is mostly in daylight, when nobody needs the lamp: the habit follows 1 in 20 of it."""
    days = days_of([one for day in range(21) for one in _busy_hall(day)])
    (lamp,) = found_in(days)
    assert (lamp.when, lamp.conditions) == ("hall motion occupied", ("sun is down",))
    assert lamp.done == len(lamp.occasions) == 21


def _busy_hall(day: int) -> Iterator[Happening]:
    random, is_on = Random(day), False  # noqa: S311 - a simulation
    for half_hour in range(17, 46):
        at = day * DAY + half_hour * 1800 + random.uniform(0, 1700)
        yield Happening(at, "hall motion", "occupancy", "hall motion occupied")
        if sun_is_down(at) and not is_on:
            is_on = True
            yield Happening(at + 20, "hall lamp", "on_off", "hall lamp on", "hall lamp on")
        yield Happening(at + 60, "hall motion", "occupancy", "hall motion clear")
    yield Happening(day * DAY + 23.5 * 3600, "hall lamp", "on_off", "hall lamp off")
