"""Sensors say what the world does to them."""

from __future__ import annotations

from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor


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
