"""What the judge of random days takes for a hand at a device, and for somebody who stayed in a closed room.

Its devices are those of ``homebot.integrations.thesis``.
"""

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


LONG_AWAY = Day.parse("""
[day]
start = "06:00"
length = "3h"

[rooms.hall]
doors = ["outside"]

[devices.lamp]
kind = "lamp"
room = "hall"

[devices.motion]
kind = "motion"
room = "hall"

[devices.door]
kind = "contact"
room = "hall"
door = "outside"

[[happenings]]
at = "06:30"
what = "restart"
lasts = "1h"
""")
BACK_AT = 7.5 * 3600
CONTROL = {"presence_guard": {"absent_after": 10.0, "doors": {"hall": ["door"]}}}


@pytest.mark.parametrize(("seconds_later", "is_unseen"), [(300.0, True), (400.0, False)])
def test_a_contact_is_known_again_after_its_next_heartbeat_where_the_broker_was_long_away(
    seconds_later: float, *, is_unseen: bool
) -> None:
    """A random day found a command in the minutes in which nobody could know that the door was closed."""
    truth = GroundTruth(LONG_AWAY.world(), RandomDay(LONG_AWAY, CONTROL, {}, (), seed=0))
    truth.begin()
    truth.add(Event(LONG_AWAY.start + 10, "door", "says", "open"))
    truth.add(Event(LONG_AWAY.start + 12, "door", "says", "closed"))
    truth.add(Event(BACK_AT + 100, "motion", "says", "motion"))
    truth.add(Event(BACK_AT + 200, "motion", "says", "clear"))
    truth.add(Event(BACK_AT + seconds_later, "lamp", "told", "off"))
    assert truth.commands[-1].is_unseen is is_unseen
