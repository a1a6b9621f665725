"""Doors and windows are open or closed, whatever their contacts report."""

import random

import pytest

from homebot.errors import UsageError
from homebot.house.faults import Stuck, Unplugged
from homebot.house.household import Habit, Person
from homebot.house.rooms import OUTSIDE, Room, Rooms
from homebot.house.sensors import SimulatedContactSensor
from homebot.house.simulated_device import Placed, SimulatedDevice
from homebot.house.world import World

PLAN = Rooms({OUTSIDE: Room(window=1.0), "hall": Room()}, [(OUTSIDE, "hall")])
ANNA = Person("anna", [Habit(99.0, "hall")], OUTSIDE, asleep=False)
RANDOM = random.Random(1)  # noqa: S311  # numbers of a game, no secrets


def door(contact: SimulatedDevice | None = None) -> World:
    """Anna, who comes in at 100."""
    return World(PLAN, [Placed(contact or SimulatedContactSensor("door"), "hall", door=OUTSIDE)], [ANNA])


def said(world: World, until: float) -> list[tuple[float, str]]:
    return [(event.at, event.what) for event in world.run_until(until) if event.verb == "says"]


def test_a_door_is_open_while_a_person_goes_through() -> None:
    world = door()
    world.run_until(99.9)
    assert not world.is_open("door")
    world.run_until(100.0)
    assert world.is_open("door")
    world.run_until(103.0)
    assert not world.is_open("door")


def test_a_door_that_hands_open_stays_open_until_they_close_it() -> None:
    """Also behind somebody who goes through."""
    world = door()
    world.press("door", "open", 50.0)
    assert said(world, 200.0) == []
    assert world.is_open("door")
    closed = world.press("door", "close", 200.0)
    assert [event.what for event in closed] == ["close", "closed"]
    assert not world.is_open("door")


def test_a_door_closed_by_hand_stays_closed() -> None:
    world = door()
    world.run_until(101.0)
    world.press("door", "close", 101.0)
    assert not world.is_open("door")
    assert said(world, 200.0) == []


def test_a_stuck_contact_does_not_notice_that_its_door_is_open() -> None:
    world = door(Stuck(SimulatedContactSensor("door"), RANDOM))
    assert [event.verb for event in world.press("door", "open", 50.0)] == ["switch"]
    assert world.is_open("door")
    assert world.device("door").state() == "closed"


def test_a_contact_without_power_tells_when_it_returns_that_its_door_was_opened() -> None:
    world = door(Unplugged(SimulatedContactSensor("door"), RANDOM, since=10.0, until=60.0))
    world.press("door", "open", 50.0)
    assert said(world, 70.0) == [(60.0, "open")]


def test_hands_do_nothing_else_to_a_contact() -> None:
    world = door()
    assert [event.verb for event in world.press("door", "nonsense", 50.0)] == ["switch"]
    assert not world.is_open("door")
    with pytest.raises(UsageError, match="no device 'gate'"):
        world.is_open("gate")
