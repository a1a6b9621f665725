"""Simulated lamps, locks, motors and thermostats."""

from __future__ import annotations

import random

import pytest

from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor


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
