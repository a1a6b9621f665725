"""How many frames a client may send."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from homebot.bridges.rosbridge.frame_rate import FrameRate


def test_a_whole_second_may_come_at_once_and_then_each_frame_waits() -> None:
    rate = FrameRate(100, 0.0)
    assert [rate.take(0.0) for _ in range(100)] == [0.0] * 100
    assert rate.take(0.0) == 0.01
    assert rate.take(10.0) == 0.0


@given(st.lists(st.floats(0, 2), max_size=300), st.integers(1, 50))
def test_no_more_than_the_limit_a_second_and_a_second_in_advance(pauses: list[float], limit: int) -> None:
    rate = FrameRate(limit, 0.0)
    now = 0.0
    for handled, pause in enumerate(pauses, 1):
        now += pause
        now += rate.take(now)
        assert handled <= limit * (now + 1) + 1e-6
