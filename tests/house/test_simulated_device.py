"""Every device is a state machine that is told the time."""

import copy
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.house.devices import SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.faults import Deaf
from homebot.house.robot import Robot
from homebot.house.rooms import Room, Rooms
from homebot.house.sensors import SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice, number, number_text


def test_time_never_goes_back() -> None:
    """An older time is passed over."""
    lamp = SimulatedLamp("lamp")
    lamp.advance(10.0)
    lamp.advance(5.0)
    assert lamp.now == 10.0


def test_due_reports_come_before_the_answer_to_a_command() -> None:
    """A motor that arrived meanwhile says so first."""
    motor = WindowMotor("motor", travel_time=3.0)
    motor.handle_command("open", 0.0)
    assert motor.handle_command("close", 10.0) == ("open", "closing")


@pytest.mark.parametrize("text", ["", "bright", "nan", "inf", "-0.1", "1.1"])
def test_a_number_out_of_range_is_none(text: str) -> None:
    """Not a number, not finite, or outside."""
    assert number(text, 0.0, 1.0) is None


@pytest.mark.parametrize(
    ("value", "text"), [(0.5, "0.5"), (20.0, "20"), (-0.0001, "0"), (100_000.0, "100000"), (19.26, "19.26")]
)
def test_numbers_are_spoken_without_needless_digits(value: float, text: str) -> None:
    """And never with an exponent."""
    assert number_text(value) == text


@given(st.floats(min_value=-1e6, max_value=1e6))
def test_a_spoken_number_is_heard_again_to_a_thousandth(value: float) -> None:
    """Whatever its size."""
    assert float(number_text(value)) == pytest.approx(value, abs=0.000_51)


def test_a_device_without_words_for_a_number_rounds_to_whole_ones() -> None:
    """No digits, no point."""
    assert number_text(120.4, 0) == "120"


def test_most_devices_feel_nothing_and_draw_nothing() -> None:
    """A lamp is not moved by the world, and a contact lives on its battery."""
    lamp, contact = SimulatedLamp("lamp"), SimulatedContactSensor("door")
    assert (lamp.apply_input(1.0, 5.0), lamp.now, lamp.state()) == ((), 5.0, "off")
    assert (contact.watts(), contact.restore()) == (0.0, "")


DICE = random.Random(0)  # noqa: S311 - physics, no secrets
DEVICES: tuple[SimulatedDevice, ...] = (
    SimulatedLamp("lamp"),
    WindowMotor("motor"),
    SimulatedDoorLock("lock"),
    SimulatedThermostat("thermostat"),
    SimulatedContactSensor("contact"),
    Robot("robot", Rooms({"hall": Room(), "bath": Room(1.0), "attic": Room(2.0)}, [("hall", "bath")]), "hall"),
)
COMMANDS = st.sampled_from(
    [
        "on",
        "off",
        "open",
        "close",
        "stop",
        "lock",
        "unlock",
        "0.5",
        "1.5",
        "21",
        "3000 K",
        "9 K",
        " K",
        "go bath",
        "go attic",
        "go x",
    ]
) | st.text(max_size=6)


@given(st.sampled_from(DEVICES), COMMANDS)
def test_a_device_ignores_unknown_commands(device: SimulatedDevice, command: str) -> None:
    """Of a sensor only hands can do something, which is the world's work."""
    if isinstance(device, SimulatedContactSensor):
        assert device.handle_command(command, 1.0) == ()
        return
    fresh = copy.deepcopy(device)
    before = fresh.state()
    answer = fresh.handle_command(command, 1.0)
    assert bool(answer) == device.knows(command) == Deaf(device, DICE).knows(command)
    assert answer or fresh.state() == before
