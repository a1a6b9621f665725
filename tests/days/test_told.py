"""What the oracle takes for known, from what motion sensors and contacts said."""

import random

import pytest
from tests.days.told import Told

from homebot.house.faults import Silent, Unplugged
from homebot.house.sensors import SimulatedContactSensor
from homebot.house.simulated_device import Placed
from homebot.testing.virtual_house import HEARTBEAT

HOUR = 3600.0


def motion(*said: tuple[str, float]) -> Told:
    """A sensor that said ``clear`` at the beginning, and then these."""
    told = Told(0.0)
    for word, at in (("clear", 0.0), *said):
        told.take(word, at)
    return told


def test_somebody_who_moves_after_the_doors_were_closed_has_stayed() -> None:
    told = motion(("motion", 20.0), ("clear", 80.0))
    assert told.moved_since(10.0, 300.0)
    assert not told.moved_since(20.0, 300.0)  # it may have been before


def test_somebody_who_goes_on_moving_for_long_has_stayed() -> None:
    told = motion(("motion", 5.0), ("clear", 400.0))
    assert told.moved_since(10.0, 300.0)
    assert not told.moved_since(100.0, 300.0)


def test_an_older_motion_counts_behind_a_newer_one() -> None:
    """All that was said is known."""
    assert motion(("motion", 20.0), ("clear", 500.0), ("motion", 600.0), ("clear", 660.0)).moved_since(10.0, 300.0)


def test_what_is_said_at_this_moment_is_on_its_way() -> None:
    told = motion(("motion", 20.0), ("clear", 80.0), ("motion", 200.0))
    assert told.clear_for(200.0) == 120.0
    assert told.clear_for(200.1) == 0.0


def test_what_a_sensor_says_that_never_detected_anybody_tells_nothing() -> None:
    told = motion(("motion", 20.0))
    assert (told.clear_for(10.0), told.clear_for(20.0)) == (0.0, 0.0)


def test_a_contact_has_been_closed_since_it_said_so_first() -> None:
    told = Told(0.0)
    for word, at in (("closed", 0.0), ("open", 10.0), ("closed", 13.0), ("closed", 20.0)):
        told.take(word, at)
    assert (told.word, told.at, told.has_opened) == ("closed", 13.0, True)


@pytest.mark.parametrize(("dialect", "known_after"), [("thesis", HOUR), ("homeassistant", 24 * HOUR)])
def test_silence_is_not_known_before_the_last_report_is_stale_and_must_be_soon_after(
    dialect: str, known_after: float
) -> None:
    """One that says when it is online may be trusted longer: if it said so live, not before homebot was there."""
    silent = Silent(SimulatedContactSensor("door"), random.Random(1), since=1000.0)  # noqa: S311  # no secrets
    placed = Placed(silent, "hall", dialect=dialect)
    told = Told(0.0)
    assert told.trusted_until(placed, 0.0) == float("inf")
    silent.advance(1000.0)
    assert told.trusted_until(placed, 0.0) == 1000.0 - HEARTBEAT + HOUR
    assert told.silence_known_from(placed, 0.0) == 1000.0 + 120.0 + known_after


def test_a_contact_that_says_when_it_is_online_is_known_to_have_lost_its_power() -> None:
    unplugged = Unplugged(SimulatedContactSensor("door"), random.Random(1), since=1000.0)  # noqa: S311  # no secrets
    unplugged.advance(1000.0)
    told = Told(0.0, power_at=1000.0)
    known = Placed(unplugged, "hall", dialect="homeassistant"), Placed(unplugged, "hall")
    assert [told.trusted_until(one, 0.0) for one in known] == [1000.0, 1000.0 - HEARTBEAT + HOUR]
    assert [told.silence_known_from(one, 0.0) for one in known] == [1120.0, 1000.0 + HOUR + 120.0]


def test_a_contact_that_was_silent_before_homebot_began_is_not_trusted_for_a_day() -> None:
    """Its retained message that it is online may be old."""
    silent = Silent(SimulatedContactSensor("door"), random.Random(1), since=0.0)  # noqa: S311  # no secrets
    silent.advance(HOUR)
    placed = Placed(silent, "hall", dialect="homeassistant")
    assert Told(HOUR).trusted_until(placed, HOUR) == 2 * HOUR - HEARTBEAT
