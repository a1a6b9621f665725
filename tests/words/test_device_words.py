"""Each text for a value is one that a routine reads, and means this device alone."""

from itertools import product

import pytest
from tests.recorded_house import HOUSE

from homebot.devices.value import PlainValue
from homebot.words.device_words import DeviceWords
from homebot.words.steps import Do, read_step
from homebot.words.triggers import read_trigger

WORDS = DeviceWords(HOUSE)
VALUES: tuple[PlainValue, ...] = (True, False, 40.0, 20.9, "open", "closed", "opening", "locked", "", "x y", "on")


@pytest.mark.parametrize(
    ("device", "capability", "value", "text"),
    [
        ("hall_lamp_two", "on_off", True, "Hall lamp two on"),
        ("hall_lamp", "on_off", False, 'name="Hall lamp" off'),  # "Hall lamp" fits "Hall lamp two" as well
        ("hall_motion", "occupancy", True, "Hall motion occupied"),
        ("front_door", "contact", True, "Front door open"),
        ("anna", "at_home", True, "Anna arrives"),
        ("anna", "at_home", False, "Anna has left"),
        ("household", "at_home", False, "everybody has left"),
        ("blind", "movement", "closed", "Blind closed"),
        ("double_relay", "on_off", True, ""),  # either half
        ("twin", "on_off", True, ""),
        ('"quoted"_lamp', "on_off", True, ""),
        ("gone", "on_off", True, ""),
    ],
)
def test_a_value_is_a_trigger(device: str, capability: str, value: PlainValue, text: str) -> None:
    assert WORDS.trigger(device, "", capability, value) == text


@pytest.mark.parametrize(
    ("device", "capability", "value", "text"),
    [
        ("hall_lamp", "level", 38.4, 'name="Hall lamp" 40 %'),
        ("bath_heating", "heating_setpoint", 20.9, "Bath heating 21 °C"),
        ("hall_lamp_two", "on_off", True, "Hall lamp two on"),
        ("blind", "movement", "closed", "Blind close"),
        ("blind", "movement", "closing", ""),
        ("blind", "position", 0.0, ""),  # says the same as closed
        ("blind", "position", 52.0, "Blind 50 %"),
        ("front_door_lock", "lock", "unlocked", ""),  # always asks
        ("hall_motion", "occupancy", True, ""),
    ],
)
def test_a_value_is_a_step(device: str, capability: str, value: PlainValue, text: str) -> None:
    assert WORDS.step(device, "", capability, value) == text


@pytest.mark.parametrize(
    ("device", "part", "value", "text"),
    [
        ("hall_button", "", "double", "Hall button press double"),
        ("hall_button", "", "04-A2", "Hall button press 04-A2"),  # a tag
        ("hall_button", "", "", ""),
        ("hall_button", "", 'a" b', ""),
        ("hall_button", "", "x\x1b[2J", ""),
        ("hall_button", "", "a\nb", ""),
        ("sofa_pad", "2", "hold", "Sofa pad#2 press hold"),
        ("sofa_pad", "3", "hold", ""),
        ("gone", "", "hold", ""),
    ],
)
def test_a_press_is_a_trigger_of_its_button(device: str, part: str, value: str, text: str) -> None:
    assert WORDS.press(device, part, value) == text


def test_every_text_is_read_and_hostile_names_mean_nothing_else() -> None:
    capabilities = {can.name for one in HOUSE for part in one.parts for can in part.part.capabilities}
    found = 0
    for one, capability, value in product(HOUSE, sorted(capabilities), VALUES):
        if trigger := WORDS.trigger(one.id, "", capability, value):
            read_trigger(trigger)
            found += 1
        if step := WORDS.step(one.id, "", capability, value):
            read = read_step(step)
            assert isinstance(read, Do)
            assert read.target == WORDS.reference(one.id)
    assert found > 20
