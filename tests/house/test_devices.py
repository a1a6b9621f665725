"""Simulated lamps, locks, motors, thermostats, sensors, tags and robots."""

import math
import random

import pytest

from homebot.house.description import parse_world
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.robot import Robot
from homebot.house.rooms import Room, Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.tag import SimulatedTag
from homebot.places.rigid import MapPose


def test_a_lamp_is_dimmed_by_a_number() -> None:
    """It draws and gives light in proportion."""
    lamp = SimulatedLamp("lamp", rated_watts=10.0, rated_lux=200.0)
    assert lamp.handle_command("0.5", 1.0) == ("0.5",)
    assert (lamp.state(), lamp.watts(), lamp.lux()) == ("on", 5.0, 100.0)


def test_a_lamp_dimmed_to_nothing_is_off_and_remembers_how_bright_it_was() -> None:
    """As dimmers do."""
    lamp = SimulatedLamp("lamp", is_on=True, brightness=0.4)
    lamp.handle_command("0", 1.0)
    assert (lamp.state(), lamp.watts(), lamp.lux()) == ("off", 0.0, 0.0)
    lamp.handle_command("on", 2.0)
    assert lamp.brightness == 0.4


def test_a_lamp_takes_a_colour_temperature_in_kelvin() -> None:
    """Also while it is off."""
    lamp = SimulatedLamp("lamp")
    assert lamp.handle_command("4000 K", 1.0) == ("4000 K",)
    assert (lamp.kelvin, lamp.is_on) == (4000.0, False)


@pytest.mark.parametrize("command", ["1.5", "-1", "90000 K", "warm K", "2700", ""])
def test_a_lamp_ignores_unknown_commands(command: str) -> None:
    """It says nothing and stays as it is."""
    lamp = SimulatedLamp("lamp", is_on=True)
    assert lamp.handle_command(command, 1.0) == ()
    assert (lamp.state(), lamp.brightness, lamp.kelvin) == ("on", 1.0, 2700.0)


def test_a_lock_turns_and_says_where_it_ended() -> None:
    """It is locked until the bolt is in."""
    lock = SimulatedDoorLock("lock", travel_time=2.0)
    assert lock.handle_command("unlock", 1.0) == ("unlocking",)
    assert lock.is_locked
    assert lock.advance(3.0) == ("unlocked",)
    assert not lock.is_locked
    assert lock.restore() == "unlock"


def test_a_jammed_lock_is_as_locked_as_it_was() -> None:
    """And says that it is jammed."""
    lock = SimulatedDoorLock("lock", jams=1.0, rng=random.Random(1))  # noqa: S311  # no secrets
    lock.handle_command("unlock", 0.0)
    assert lock.advance(2.0) == ("jammed",)
    assert lock.is_locked


def test_a_lock_that_jammed_tries_again() -> None:
    """About every other turn of this one works."""
    lock = SimulatedDoorLock("lock", jams=0.5, rng=random.Random(1))  # noqa: S311  # no secrets
    ends: set[str] = set()
    for turn in range(20):
        lock.handle_command("lock", turn * 10.0)
        ends.update(lock.advance(turn * 10.0 + 5.0))
    assert ends == {"jammed", "locked"}


def test_a_lock_knows_two_words() -> None:
    """Others it ignores."""
    assert SimulatedDoorLock("lock").handle_command("open", 0.0) == ()


def test_a_motor_moves_at_one_speed_and_says_where_it_arrived() -> None:
    """Half of the way in half of the time."""
    motor = WindowMotor("motor", travel_time=4.0)
    assert motor.handle_command("open", 10.0) == ("opening",)
    assert motor.next_event() == 14.0
    assert motor.advance(12.0) == ()
    assert (motor.position, motor.state(), motor.watts()) == (0.5, "opening", 40.0)
    assert motor.advance(14.0) == ("open",)
    assert (motor.position, motor.is_open, motor.next_event(), motor.watts()) == (1.0, True, None, 0.0)


def test_a_motor_stops_mid_way_and_says_where() -> None:
    """And goes on from there."""
    motor = WindowMotor("motor", travel_time=4.0)
    motor.handle_command("open", 0.0)
    assert motor.handle_command("stop", 1.0) == ("0.25",)
    assert motor.advance(100.0) == ()
    motor.handle_command("close", 100.0)
    assert motor.advance(101.0) == ("closed",)


def test_a_motor_turns_round_on_the_way() -> None:
    """It needs as long back as it went."""
    motor = WindowMotor("motor", travel_time=4.0)
    motor.handle_command("open", 0.0)
    assert motor.handle_command("close", 3.0) == ("closing",)
    assert motor.next_event() == 6.0


def test_a_motor_goes_to_a_position() -> None:
    """A number from 0 to 1."""
    cover = CoverMotor("cover", travel_time=10.0)
    assert cover.handle_command("0.25", 0.0) == ("closing",)
    assert cover.advance(7.5) == ("0.25",)
    assert cover.restore() == "0.25"


def test_a_motor_that_is_there_says_so() -> None:
    """It does not move."""
    motor = WindowMotor("motor", is_open=True)
    assert motor.handle_command("open", 1.0) == ("open",)
    assert motor.next_event() is None


@pytest.mark.parametrize("command", ["1.01", "ajar", "on"])
def test_a_motor_ignores_unknown_commands(command: str) -> None:
    """It says nothing."""
    assert WindowMotor("motor").handle_command(command, 1.0) == ()


def test_an_unheated_room_cools_towards_the_weather() -> None:
    """To 1/e of the distance within its inertia."""
    room = SimulatedThermostat("room", celsius=20.0, outside=10.0, target=5.0, inertia=3000.0)
    reports = room.advance(3000.0)
    assert room.celsius == pytest.approx(10.0 + 10.0 / 2.718281828, abs=0.01)
    assert [float(report) for report in reports] == sorted((float(report) for report in reports), reverse=True)


def test_a_heated_room_stays_near_its_target() -> None:
    """In winter, over a day; heating goes on and off."""
    room = SimulatedThermostat("room", celsius=20.0, target=21.0, outside=-5.0)
    room.advance(20_000.0)
    powers = set()
    for hour in range(24):
        room.advance(20_000.0 + hour * 3600.0)
        powers.add(room.watts())
        assert room.celsius == pytest.approx(21.0, abs=1.0)
    assert powers == {0.0, 1000.0}


def test_a_thermostat_takes_a_target_and_says_it() -> None:
    """A number of degrees from 5 to 30."""
    room = SimulatedThermostat("room")
    assert room.handle_command("22.5", 1.0) == ("22.5",)
    assert room.restore() == "22.5"
    assert room.handle_command("50", 2.0) == ()


def test_a_contact_reports_changes() -> None:
    """And nothing twice."""
    contact = SimulatedContactSensor("door")
    assert contact.apply_input(1, 0.0) == ("open",)
    assert contact.apply_input(1, 1.0) == ()
    assert contact.apply_input(0, 2.0) == ("closed",)


def test_a_motion_sensor_is_clear_a_while_after_the_last_motion() -> None:
    """Somebody who comes back in time keeps it in motion."""
    motion = MotionSensor("hall", hold=60.0)
    assert motion.apply_input(1, 0.0) == ("motion",)
    assert motion.apply_input(0, 10.0) == ()
    assert motion.apply_input(2, 69.0) == ()
    assert motion.apply_input(0, 80.0) == ()
    assert motion.apply_input(0, 90.0) == ()
    assert motion.next_event() == 140.0
    assert motion.advance(139.0) == ()
    assert motion.advance(140.0) == ("clear",)
    assert (motion.state(), motion.next_event()) == ("clear", None)


def test_a_person_may_walk_past_a_motion_sensor() -> None:
    motion = MotionSensor("hall", hold=60.0)
    assert motion.operate_manually("nonsense", 0.0) == ()
    assert motion.operate_manually("motion", 1.0) == ("motion",)
    assert motion.operate_manually("motion", 31.0) == ()
    assert motion.advance(90.0) == ()
    assert motion.advance(91.0) == ("clear",)


def test_a_passer_by_does_not_hide_a_person_that_stays() -> None:
    motion = MotionSensor("hall", hold=60.0)
    assert motion.apply_input(1, 0.0) == ("motion",)
    assert motion.operate_manually("motion", 1.0) == ()
    assert motion.advance(1000.0) == ()


def test_a_light_sensor_says_changes_that_are_worth_a_word() -> None:
    """A fifth of the last word, and never under 1 lux."""
    lux = LuxSensor("living")
    assert lux.apply_input(0.5, 0.0) == ()
    assert lux.apply_input(100.0, 1.0) == ("100",)
    assert lux.apply_input(119.0, 2.0) == ()
    assert lux.apply_input(120.0, 3.0) == ("120",)


def test_a_power_meter_says_watts() -> None:
    """As text."""
    meter = PowerMeter("meter")
    assert meter.apply_input(12.34, 0.0) == ("12.3",)
    assert meter.apply_input(12.9, 1.0) == ()
    assert meter.state() == "12.3"


def test_a_sensor_takes_no_command() -> None:
    """It says nothing to it."""
    assert SimulatedContactSensor("door").handle_command("open", 0.0) == ()


def test_a_tag_is_at_the_reader_for_a_while() -> None:
    tag = SimulatedTag("tag", "hall_lamp")
    assert tag.state() == "away"
    assert tag.handle_command("tap", 10.0) == ("hall_lamp",)
    assert tag.handle_command("tap", 11.0) == ()
    assert (tag.state(), tag.next_event()) == ("hall_lamp", 13.0)
    assert tag.advance(20.0) == ("away",)
    assert tag.next_event() is None


def test_a_tag_that_is_tapped_again_and_again_comes_and_goes() -> None:
    tag = SimulatedTag("tag", "hall_lamp", hold=1.0, every=60.0)
    assert tag.advance(130.0) == ("hall_lamp", "away") * 2
    assert tag.next_event() == 180.0


def test_a_timer_of_a_house_taps_it() -> None:
    tables = {
        "rooms": {"hall": {}},
        "devices": {"tag": {"kind": "tag", "room": "hall", "text": "lamp"}},
        "errands": [{"at": "07:00", "device": "tag", "command": "tap"}],
    }
    world = parse_world(tables, "test")
    said = [event.what for event in world.run_until(8 * 3600.0) if event.verb == "says"]
    assert said == ["lamp", "away"]


PLAN = Rooms(
    {"hall": Room(), "living": Room(x=4.0), "kitchen": Room(x=4.0, y=2.0), "loft": Room()},
    [("hall", "living"), ("living", "kitchen")],
)


def test_a_robot_says_each_room_on_its_way() -> None:
    """Its pose is between them at its speed."""
    robot = Robot("robot", PLAN, "hall", speed=0.5)
    assert robot.handle_command("go kitchen", 0.0) == ("moving",)
    assert robot.advance(4.0) == ()
    assert robot.pose() == MapPose(2.0, 0.0, 0.0)
    assert robot.advance(8.0) == ("living",)
    assert robot.advance(12.0) == ("kitchen",)
    assert robot.pose() == MapPose(4.0, 2.0, math.pi / 2)
    assert (robot.state(), robot.next_event()) == ("kitchen", None)


def test_a_stopped_robot_stays_and_drives_on_from_there() -> None:
    """First back to the middle of the room it left."""
    robot = Robot("robot", PLAN, "hall", speed=0.5)
    robot.handle_command("go living", 0.0)
    assert robot.handle_command("stop", 4.0) == ("hall",)
    assert robot.advance(100.0) == ()
    assert robot.pose() == MapPose(2.0, 0.0, 0.0)
    robot.handle_command("go hall", 100.0)
    assert robot.advance(104.0) == ("hall",)
    assert (robot.pose().x, robot.pose().y) == (0.0, 0.0)


def test_a_robot_that_is_there_says_so() -> None:
    """It does not move."""
    assert Robot("robot", PLAN, "hall").handle_command("go hall", 0.0) == ("hall",)


@pytest.mark.parametrize("command", ["go loft", "go moon", "dance"])
def test_a_robot_ignores_unknown_commands(command: str) -> None:
    """No way, no room, no such command."""
    assert Robot("robot", PLAN, "hall").handle_command(command, 0.0) == ()
