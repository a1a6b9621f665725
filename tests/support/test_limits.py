"""Limits on how often something happens."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.support.limits import Limiter, LimitInterval, RateLimit


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


class Limited:
    """A limit of two of each kind in ten seconds, for two kinds, and what was held back when an interval was over."""

    def __init__(self) -> None:
        self.over: list[tuple[str, str | None, int]] = []
        self.kinds = Limiter[str, str](10.0, 2, self._on_interval_end)

    def admit(self, kind: str, item: str, now: float = 0.0) -> bool:
        return self.kinds.of(kind, now).admit(2, item)

    def _on_interval_end(self, kind: str, interval: LimitInterval[str]) -> None:
        self.over.append((kind, *interval.release()))


def test_what_an_interval_holds_back_is_known_when_the_next_begins() -> None:
    limited = Limited()
    assert [limited.admit("a", item) for item in ("1", "2", "3", "4")] == [True, True, False, False]
    assert limited.admit("b", "1", now=9.0)
    assert limited.over == []
    assert limited.admit("a", "5", now=10.0)
    assert limited.over == [("a", "4", 2)]
    assert limited.kinds["a"] is limited.kinds.of("a", 19.9)


def test_the_kind_that_was_used_least_recently_makes_room_as_if_it_were_over() -> None:
    limited = Limited()
    for kind in ("a", "b", "a", "a", "c"):
        limited.admit(kind, kind)
    assert limited.over == [("b", None, 0)]
    assert (list(limited.kinds), limited.kinds["a"].held_back) == (["a", "c"], 1)


@pytest.mark.parametrize(("now", "left"), [(9.9, ["a", "b"]), (10.0, ["b"]), (15.0, []), (-1.0, [])])
def test_intervals_that_are_over_are_dropped_also_when_the_clock_goes_back(now: float, left: list[str]) -> None:
    limited = Limited()
    limited.admit("a", "1")
    limited.admit("b", "1", now=5.0)
    limited.kinds.drop(now)
    assert list(limited.kinds) == left


def test_a_limit_without_an_owner_goes_on_counting_until_the_number_is_released() -> None:
    kinds = Limiter[str, None](10.0, 2)
    assert [kinds.of("a", now).admit(1) for now in (0.0, 1.0, 10.0, 11.0)] == [True, False, True, False]
    assert kinds.of("a", 12.0).release() == (None, 2)
    assert kinds.of("a", 12.0).release() == (None, 0)
