"""The light service on random days: run it with ``pytest``. Needs ``pip install 'homebot[testing]'``."""

from pathlib import Path

from hypothesis import given, settings

from homebot.house import World
from homebot.testing import Day, live_day
from homebot.testing.strategies import days, houses

FAULTS = ["deaf", "liar", "slow", "reverter", "lossy", "unplugged", "flapper"]  # the others talk much: slow to test
HOMES = houses(kinds=["lamp", "motion", "contact"], faults=FAULTS, max_rooms=3, min_devices=1, max_devices=4)
PATIENCE = 600.0
"""Seconds within which a lamp must be sent `off`: two of its heartbeats."""


def lamps_left_on(day: Day, world: World) -> list[str]:
    """Name each "on" that nobody answered, once the wire had been whole for a while."""
    mended = max((event.at + event.lasts for event in day.happenings if event.what in {"pull", "restart"}), default=0.0)
    events = world.event_log.since(0)
    left_on = []
    for number, event in enumerate(events):
        deadline = max(event.at, mended, day.start) + PATIENCE
        if (event.verb, event.what) == ("says", "on") and deadline < day.end:
            later = [each for each in events[number + 1 :] if each.who == event.who and each.at <= deadline]
            told = any((each.verb, each.what) == ("told", "off") for each in later)
            changed = any(each.verb == "power" or (each.verb == "says" and each.what != "on") for each in later)
            if not (told or changed):
                left_on.append(str(event))
    return left_on


@settings(max_examples=10, deadline=None, derandomize=True)
@given(days(HOMES, max_length="4h"))
def test_whatever_happens_a_lamp_that_says_on_is_told_off(day: Day) -> None:
    assert lamps_left_on(day, live_day(day, "light_service")) == []


def test_a_saved_day_is_lived_again() -> None:
    day = Day.load(Path(__file__).with_name("cable_pulled.toml"))
    world = live_day(day, "light_service")
    assert lamps_left_on(day, world) == []
    told = [str(event) for event in world.event_log.since(0) if event.verb == "told"]
    assert told[0] == "0 18:30:00.000 lamp told off"  # when it was plugged in again
