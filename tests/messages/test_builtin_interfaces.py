"""Points and spans of time."""

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from homebot.messages import Duration, Time


@pytest.mark.parametrize(
    ("seconds", "sec", "nanosec"),
    [(0.0, 0, 0), (1.5, 1, 500_000_000), (-0.5, -1, 500_000_000), (0.9999999999, 1, 0), (-1.0, -1, 0), (-1e-20, 0, 0)],
)
@pytest.mark.parametrize("kind", [Time, Duration])
def test_nanoseconds_count_up_from_the_whole_second_below(
    kind: type[Time | Duration], seconds: float, sec: int, nanosec: int
) -> None:
    assert kind.from_seconds(seconds) == kind(sec=sec, nanosec=nanosec)


@given(st.floats(-(2.0**31), 2.0**31 - 1))
def test_seconds_come_back_to_the_nanosecond(seconds: float) -> None:
    for kind in (Time, Duration):
        there = kind.from_seconds(seconds)
        assert there.to_seconds() == pytest.approx(seconds, abs=1e-6)
        assert 0 <= there.nanosec < 1_000_000_000


@given(st.floats(1e9, 2.0**31 - 1))
@example(1795456256.916278)  # counted in nanoseconds, it is rounded to those of the float below it
def test_a_time_comes_back_exactly_so_that_what_happens_at_once_is_at_once(seconds: float) -> None:
    assert Time.from_seconds(seconds).to_seconds() == seconds
