"""Durations as people write them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import UsageError
from homebot.units import parse_duration


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("90s", 90.0),
        ("8h", 28_800.0),
        ("1h30m", 5_400.0),
        ("1h 30m", 5_400.0),
        (" 2 d ", 172_800.0),
        ("1.5d", 129_600.0),
        ("500ms", 0.5),
        ("1m500ms", 60.5),
        ("1d2h3m4s5ms", 93_784.005),
        ("0s", 0.0),
        (90, 90.0),
        (0.25, 0.25),
    ],
)
def test_a_duration_is_read(text: str | float, seconds: float) -> None:
    assert parse_duration(text) == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["", " ", "8", "8 hours", "h", "30m1h", "1h1h", "-5s", "1,5h", "8H", "1..5s", "٣s"])
def test_what_is_no_duration_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match=r"is not a duration; write it like 90s, 8h or 1h30m"):
        parse_duration(text)


@pytest.mark.parametrize("number", [-1.0, math.inf, math.nan])
def test_a_number_that_is_no_time_is_refused(number: float) -> None:
    with pytest.raises(UsageError, match="finite number of seconds, 0 or more"):
        parse_duration(number)


@given(st.integers(0, 99), st.integers(0, 99), st.integers(0, 99))
def test_parts_add_up(hours: int, minutes: int, seconds: int) -> None:
    assert parse_duration(f"{hours}h{minutes}m{seconds}s") == hours * 3600 + minutes * 60 + seconds
