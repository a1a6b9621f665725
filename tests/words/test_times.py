"""One meaning for a length of time, days and a span, whoever reads them."""

from datetime import time

import pytest

from homebot.units import parse_duration
from homebot.words.conditions import OnDays, read_condition
from homebot.words.days import CalendarDays, read_days
from homebot.words.steps import Wait, read_step
from homebot.words.times import TimeSpan
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
