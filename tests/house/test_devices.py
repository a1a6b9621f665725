"""Simulated devices obey like real ones: they report what they did, and some take their time."""

from __future__ import annotations

from homebot.house import Lamp, Step, WindowMotor, thesis_devices


def test_a_lamp_reports_what_it_was_told_at_once() -> None:
    """On and off."""
    lamp = Lamp("lamp", is_on=True)
    assert lamp.state() == "on"
    assert lamp.obey("off") == (Step(0.0, "off"),)
    assert lamp.state() == "off"


def test_an_unknown_command_is_ignored() -> None:
    """As cheap lamps do."""
    lamp = Lamp("lamp")
    assert lamp.obey("dance") == ()
    assert WindowMotor("motor").obey("on") == ()
    assert lamp.state() == "off"


def test_a_window_motor_takes_its_time() -> None:
    """It says that it moves, then where it arrived."""
    motor = WindowMotor("motor", travel_time=2.0)
    assert motor.obey("open") == (Step(0.0, "opening"), Step(2.0, "open"))
    assert motor.obey("close") == (Step(0.0, "closing"), Step(2.0, "closed"))


def test_the_house_of_the_thesis_has_two_lamps_one_on_and_a_window_motor() -> None:
    """The experiment of chapter 8."""
    devices = thesis_devices()
    assert [device.service_type for device in devices] == ["lights", "lights", "windows"]
    assert [device.state() for device in devices] == ["on", "off", "closed"]
