"""How often something may happen."""

from hypothesis import given
from hypothesis import strategies as st

from homebot.support.rate_limit import RateLimit


def test_a_whole_second_may_come_at_once_and_then_each_frame_waits() -> None:
    rate = RateLimit(100, at_once=100)
    assert [rate.charge(0.0) for _ in range(100)] == [0.0] * 100
    assert rate.charge(0.0) == 0.01
    assert rate.charge(10.0) == 0.0


@given(st.lists(st.floats(0, 2), max_size=300), st.integers(1, 50))
def test_no_more_than_the_limit_a_second_and_a_second_in_advance(pauses: list[float], limit: int) -> None:
    rate = RateLimit(limit, at_once=limit)
    now = 0.0
    for handled, pause in enumerate(pauses, 1):
        now += pause
        now += rate.charge(now)
        assert handled <= limit * (now + 1) + 1e-6


def test_what_waits_no_longer_than_the_most_is_not_counted_beyond_that() -> None:
    rate = RateLimit(0.1, at_once=2, most_ahead=1)
    assert [rate.charge(5.0) for _ in range(5)] == [0.0, 0.0, 10.0, 10.0, 10.0]
    assert rate.charge(25.0) == 0.0


def test_an_amount_counts_as_a_whole() -> None:
    rate = RateLimit(10, at_once=100)
    assert rate.charge(0.0, 100) == 0.0
    assert rate.charge(0.0, 20) == 2.0
    assert rate.charge(12.0, 100) == 0.0


def test_what_is_not_admitted_is_not_counted() -> None:
    rate = RateLimit(5, at_once=2)
    assert [rate.admits(1.0) for _ in range(4)] == [True, True, False, False]
    assert rate.admits(1.25)
    assert not rate.admits(1.25)
