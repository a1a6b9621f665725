"""One meaning for a length of time, days and a span, whoever reads them."""

from datetime import UTC, time, timedelta, timezone

import pytest

from homebot.errors import UsageError
from homebot.units import parse_duration
from homebot.words.conditions import OnDays, read_condition
from homebot.words.days import CalendarDays, read_days
from homebot.words.steps import Wait, read_step
from homebot.words.times import TimeSpan, shifted_moment
from homebot.words.triggers import Becomes, read_trigger


@pytest.mark.parametrize("text", ["30m", "30 min", "30 minutes", "half an hour", "0.5 hours", "1800 seconds"])
def test_a_length_of_time_is_the_same_for_all(text: str) -> None:
    trigger, step = read_trigger(f"front door open for {text}"), read_step(f"wait {text}")
    assert isinstance(trigger, Becomes)
    assert isinstance(step, Wait)
    assert trigger.lasting == step.seconds == parse_duration(text) == 1800.0


@pytest.mark.parametrize("text", ["weekdays", "mon-fri", "mon, tue, wed, thu and fri"])
def test_days_are_the_same_for_all(text: str) -> None:
    assert read_condition(f"on {text}") == OnDays(read_days(text)) == OnDays(CalendarDays(frozenset(range(5))))


def test_a_span_whose_ends_are_one_is_a_whole_day() -> None:
    assert TimeSpan(time(22), time(22)).has(time(12))
    assert read_condition("between 22:00 and 22:00") == TimeSpan(time(22), time(22))


@pytest.mark.parametrize(
    ("text", "minutes", "meant"),
    [
        ("07:00", 0, "07:00"),
        ("00:10", -20, "23:50:00"),
        ("2026-12-24 00:10", -20, "2026-12-23 23:50:00"),
        ("2026-12-24T06:00:00+00:00", 0, "2026-12-24 07:00:00"),
        ("2026-12-24T06:00:00+00:00", 30, "2026-12-24 07:30:00"),
    ],
)
def test_a_moment_is_moved_and_told_in_the_zone_of_the_home(text: str, minutes: int, meant: str) -> None:
    assert shifted_moment(text, 60.0 * minutes, timezone(timedelta(hours=1))) == meant


def test_what_is_no_moment_is_not_moved() -> None:
    with pytest.raises(UsageError, match="time of day"):
        shifted_moment("unknown", 60.0, UTC)
