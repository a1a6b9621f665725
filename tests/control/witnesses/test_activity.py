"""What was switched lately, and what is on its way."""

from __future__ import annotations

from math import inf

from homebot.control.witnesses.activity import RecentActivity

LAMP, FAN = ("lamp", ""), ("fan", "")


def test_what_changed_since_a_time_is_told_with_what_is_on_its_way() -> None:
    activity = RecentActivity()
    activity.note(LAMP, 1.0)
    activity.note(FAN, 3.0)
    assert activity.begin("c-1", LAMP)
    assert list(activity.since(2.0, "c-2")) == [(3.0, FAN), (inf, LAMP)]
    assert list(activity.since(2.0, "c-1")) == [(3.0, FAN)]


def test_a_part_is_at_rest_when_its_last_command_is_over() -> None:
    activity = RecentActivity()
    assert activity.begin("c-1", LAMP)
    assert not activity.begin("c-2", LAMP)
    assert activity.begin("c-3", FAN)
    activity.end("c-1", 4.0)
    activity.end("c-2", 5.0)
    activity.end("c-2", 6.0)  # twice is fine
    assert activity.begin("c-4", LAMP)
    assert list(activity.since(0.0, "c-4")) == [(4.0, LAMP), (5.0, LAMP), (inf, FAN)]


def test_of_what_was_forgotten_the_time_is_known() -> None:
    activity = RecentActivity()
    for number in range(512):
        activity.note(LAMP, float(number))
    assert activity.known_since == -inf
    activity.note(LAMP, 512.0)
    assert activity.known_since == 0.0
    activity.note(LAMP, 513.0)
    assert activity.known_since == 1.0
