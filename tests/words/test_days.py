"""Days of the week and of the year, as people write them."""

from datetime import date, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import UsageError
from homebot.words.conditions import OnDays, exclude_each_other, read_condition
from homebot.words.days import read_days
from homebot.words.times import DaysAndTime
from homebot.words.triggers import read_trigger

YEAR = [date(2024, 1, 1) + timedelta(days=day) for day in range(366)]


def days_of(text: str) -> list[str]:
    """The first and the last of the days in 2024, and how many there are."""
    found = [day for day in YEAR if read_days(text).has(day)]
    return [f"{found[0]:%d %b}", f"{found[-1]:%d %b}", str(len(found))]


@pytest.mark.parametrize(
    ("text", "days"),
    [
        ("24 Dec", ["24 Dec", "24 Dec", "1"]),
        ("dec 24, 26. december", ["24 Dec", "26 Dec", "2"]),
        ("in July", ["01 Jul", "31 Jul", "31"]),
        ("from May to September", ["01 May", "30 Sep", "153"]),
        ("from 15 nov until 14 mar", ["01 Jan", "31 Dec", "121"]),
        ("sat from may to may", ["04 May", "25 May", "4"]),
        ("29 feb", ["29 Feb", "29 Feb", "1"]),
        ("", ["01 Jan", "31 Dec", "366"]),
    ],
)
def test_days_of_the_year_are_read(text: str, days: list[str]) -> None:
    assert days_of(text) == days


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("31 feb", "days: February has no day 31"),
        ("from mon to may", "days: there is no day 'may'"),
        ("12 smarch", "days: there is no day '12smarch'"),
    ],
)
def test_a_day_that_is_none_is_named(text: str, problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_days(text)
    assert str(caught.value).startswith(problem)


def test_a_routine_starts_on_a_day_of_the_year() -> None:
    assert read_trigger("on 24 Dec") == DaysAndTime("0:00", "24 dec")
    assert read_trigger("18:00 on 24 Dec") == DaysAndTime("18:00", "24 dec")
    assert read_trigger("7:30 from May to September") == DaysAndTime("7:30", "may-september")


@given(st.dates(min_value=date(2020, 1, 1), max_value=date(2030, 1, 1)))
def test_each_day_is_in_a_condition_or_in_its_denial(day: date) -> None:
    for text in ("on weekends", "in July", "on 24 Dec", "from October to March"):
        condition, denial = read_condition(text), read_condition(f"not {text}")
        assert isinstance(condition, OnDays)
        assert isinstance(denial, OnDays)
        assert condition.days.has(day) is not denial.days.has(day)
        assert exclude_each_other(condition, denial)
