"""The limit on requests, by host and for all."""

from homebot.clock import ManualClock
from homebot.support.request_limit import RequestLimit


def test_a_host_that_asks_too_often_waits_and_keeps_no_other_out() -> None:
    clock, dropped = ManualClock(), list[str]()
    limit = RequestLimit(clock, dropped.append)
    assert [limit.admits("10.0.0.66") for _ in range(1200)] == [True] * 1000 + [False] * 200
    assert limit.admits("10.0.0.7")
    assert dropped == ["10.0.0.66"] * 200
    clock.advance(1.0)
    assert [limit.admits("10.0.0.66") for _ in range(21)] == [True] * 20 + [False]


def test_hosts_that_are_all_made_up_count_together() -> None:
    limit = RequestLimit(ManualClock(), lambda _: None)
    assert [limit.admits(f"10.0.{one // 250}.{one % 250}") for one in range(6000)] == [True] * 5000 + [False] * 1000
