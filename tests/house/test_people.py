"""People have habits."""

from __future__ import annotations

from homebot.house.household import Habit, Person, Visit
from homebot.house.rooms import DAY

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
