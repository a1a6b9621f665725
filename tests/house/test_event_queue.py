"""What is to be done comes in the order of its time."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from homebot.house.event_queue import EventQueue


@given(st.lists(st.sampled_from([0.0, 1.0, 2.0, 3.0])))
def test_things_come_by_time_and_ties_by_who_came_first(times: list[float]) -> None:
    """As a stable sort would have it."""
    agenda = EventQueue()
    done: list[tuple[float, int]] = []
    entries = [(at, number) for number, at in enumerate(times)]
    for entry in entries:
        agenda.add(entry[0], lambda entry=entry: done.append(entry))  # type: ignore[misc]  # a default binds it now
    while agenda.next_at() is not None:
        agenda.pop()()
    assert done == sorted(entries, key=lambda entry: entry[0])


def test_a_plan_replaces_the_one_before() -> None:
    """Of the same one alone; None calls it off."""
    agenda = EventQueue()
    done: list[str] = []
    agenda.plan("anna", 1.0, lambda: done.append("first"))
    agenda.plan("anna", 3.0, lambda: done.append("second"))
    agenda.plan("ben", 2.0, lambda: done.append("ben"))
    agenda.plan("clara", 2.5, lambda: done.append("clara"))
    agenda.plan("clara", None, lambda: done.append("clara"))
    while agenda.next_at() is not None:
        agenda.pop()()
    assert done == ["ben", "second"]


@given(st.lists(st.tuples(st.sampled_from("abc"), st.none() | st.sampled_from([0.0, 1.0, 2.0])), max_size=100))
def test_of_any_plans_the_last_of_each_is_kept(plans: list[tuple[str, float | None]]) -> None:
    """However many were called off."""
    agenda = EventQueue()
    for who, at in plans:
        agenda.plan(who, at, lambda: None)
    times = []
    while (at := agenda.next_at()) is not None:
        agenda.pop()()
        times.append(at)
    assert times == sorted(at for at in dict(plans).values() if at is not None)


def test_one_who_plans_anew_without_end_does_not_fill_the_agenda() -> None:
    """What was called off is swept, and the last plan holds."""
    agenda = EventQueue()
    agenda.add(5.0, lambda: None)
    for number in range(1000):
        agenda.plan("anna", 10.0 + number, lambda: None)
        assert len(agenda) < 200
    assert agenda.next_at() == 5.0
    agenda.pop()
    assert agenda.next_at() == 1009.0
