"""Somebody who reads is awake, and no motion sensor sees it."""

from homebot.house.devices import SimulatedLamp
from homebot.house.household import Habit, Person
from homebot.house.rooms import DAY, OUTSIDE, Room, Rooms
from homebot.house.sensors import MotionSensor
from homebot.house.simulated_device import Placed
from homebot.house.world import World

PLAN = Rooms({OUTSIDE: Room(window=1.0), "living": Room(window=0.02)}, [(OUTSIDE, "living")])


def reading(*habits: Habit) -> World:
    """Anna, with a motion sensor and a lamp in the room."""
    devices = [Placed(MotionSensor("motion", hold=60.0), "living"), Placed(SimulatedLamp("lamp"), "living")]
    return World(PLAN, devices, [Person("anna", habits, OUTSIDE, asleep=False)])


def motion_of(world: World, until: float) -> list[tuple[float, str]]:
    return [(event.at, event.what) for event in world.run_until(until) if event.who == "motion"]


def test_a_reading_person_moves_for_a_moment_now_and_then() -> None:
    """For 20 s after coming in and every 20 minutes; the sensor holds motion for a minute."""
    world = reading(Habit(99.0, "living", still=1200.0))
    assert motion_of(world, 2000.0) == [(100.0, "motion"), (180.0, "clear"), (1320.0, "motion"), (1400.0, "clear")]
    assert world.awake_in("living") == 1


def test_a_person_that_gets_up_moves_again() -> None:
    """And leaves nothing of sitting behind: the next habit moves all the time."""
    world = reading(Habit(99.0, "living", still=3600.0), Habit(1000.0, "living"))
    assert motion_of(world, 8000.0) == [(100.0, "motion"), (180.0, "clear"), (1000.0, "motion")]


def test_a_person_that_left_does_not_move_in_the_old_room() -> None:
    world = reading(Habit(99.0, "living", still=600.0), Habit(300.0, OUTSIDE))
    assert motion_of(world, 5000.0) == [(100.0, "motion"), (180.0, "clear"), (300.0, "motion"), (361.0, "clear")]


def test_a_reading_person_gets_up_for_the_lamp_when_it_gets_dark() -> None:
    """Nobody works a lamp without a movement."""
    world = reading(Habit(12 * 3600.0, "living", still=DAY))
    world.run_until(13 * 3600.0)
    events = [(event.at, event.who, event.what) for event in world.run_until(DAY) if event.who in {"lamp", "motion"}]
    at = events[0][0]
    assert events == [(at, "motion", "motion"), (at, "lamp", "on"), (at, "lamp", "on"), (at + 80.0, "motion", "clear")]
