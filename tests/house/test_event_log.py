"""The event log keeps what happened."""

from __future__ import annotations

from homebot.house.event_log import Event, WorldLog


def test_an_event_is_one_line_with_day_time_and_fact() -> None:
    """To the millisecond; rounding carries into the next day."""
    assert str(Event(90_061.5, "lamp", "says", "on")) == "1 01:01:01.500 lamp says on"
    assert str(Event(86_399.9999, "anna", "enters", "hall")) == "1 00:00:00.000 anna enters hall"


def test_a_report_with_line_breaks_is_one_line() -> None:
    """A lamp cannot be made to forge what happened."""
    assert str(Event(0.0, "lamp", "told", "on\n0 x")) == "0 00:00:00.000 lamp told 'on\\n0 x'"


def test_a_full_log_drops_the_oldest_and_counts() -> None:
    """What came since a mark comes as far as it is kept."""
    log = WorldLog(capacity=3)
    events = [Event(float(number), "lamp", "says", "on") for number in range(5)]
    for event in events:
        log.add(event)
    assert (log.count, log.dropped) == (5, 2)
    assert log.since(4) == (events[4],)
    assert log.since(0) == tuple(events[2:])
    assert log.since(5) == ()
    assert log.text() == "".join(f"{event}\n" for event in events[2:])
