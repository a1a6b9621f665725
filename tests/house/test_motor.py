"""Motors take their time."""

from __future__ import annotations

import pytest

from homebot.house.devices import CoverMotor, WindowMotor


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
