"""What the judge of random days takes for a hand at a device."""

from __future__ import annotations

import pytest
from tests.days.random_day import RandomDay
from tests.days.truth import GroundTruth

from homebot.house.event_log import Event, Verb
from homebot.testing import Day

DAY = Day.parse("""
[day]
start = "06:00"
length = "1h"

[rooms.hall]
doors = ["outside"]

[devices.lamp]
kind = "lamp"
room = "hall"
""")


@pytest.mark.parametrize(
    ("was", "events", "expected"),
    [
        ("off", [("switch", "on"), ("says", "on")], True),
        ("off", [("switch", "on"), ("says", "on"), ("told", "off"), ("says", "off")], True),
        ("off", [("switch", "on"), ("told", "off"), ("says", "on")], True),
        ("on", [("told", "off"), ("switch", "off"), ("says", "off")], True),
        ("on", [("switch", "on"), ("told", "off"), ("says", "off")], False),
        ("on", [("switch", "on"), ("told", "0"), ("says", "off")], False),
        ("off", [("switch", "off"), ("told", "0.4"), ("says", "on")], False),
        ("on", [("switch", "on"), ("says", "on")], False),
        ("off", [("told", "on"), ("says", "on")], False),
    ],
    ids=[
        "pressed and reported",
        "pressed, reported and then told otherwise",
        "pressed, and told before it reported the hand",
        "told, and then pressed",
        "pressed without a change, and then it obeyed what it was told",
        "pressed without a change, and then dimmed to nothing",
        "pressed without a change, and then dimmed up",
        "pressed without a change",
        "told alone",
    ],
)
def test_a_hand_is_what_changed_what_the_device_reports(
    was: str, events: list[tuple[Verb, str]], *, expected: bool
) -> None:
    """In one moment. A random day found a hand that changed nothing while a command did."""
    truth = GroundTruth(DAY.world(), RandomDay(DAY, {}, {}, (), seed=0))
    truth.begin()
    now = DAY.start
    truth.add(Event(now, "lamp", "says", was))
    for verb, what in [*events, ("told", "off")]:
        truth.add(Event(now, "lamp", verb, what))
    assert truth.commands[-1].is_switched is expected
