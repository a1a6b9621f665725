"""The steps of a routine, as text."""

import pytest

from homebot.errors import UsageError
from homebot.words.steps import Do, Notify, Undo, Wait, WaitUntil, read_step


@pytest.mark.parametrize(
    ("text", "target", "command", "values"),
    [
        ("hall lamp on, 20 %", "hall lamp", "on", (("level", "20 %"),)),
        ("hall lamp on, 20 %, 2700 K", "hall lamp", "on", (("level", "20 %"), ("color_temperature", "2700 K"))),
        ("lamp on, red", "lamp", "on", (("color", "red"),)),
        ("hall lamp +10 %", "hall lamp", "+10 %", ()),
        ("hall lamp darker by 5 %", "hall lamp", "darker by 5 %", ()),
        ("lights in hall off", "lights in hall", "off", ()),
        ("thermostat in nursery to 21 °C", "thermostat in nursery", "21 °C", ()),
        ("kitchen blind position 40", "kitchen blind", "position 40", ()),
        ("robot vacuum dock", "robot vacuum", "dock", ()),
        ("open plan lamp on", "open plan lamp", "on", ()),
        ("washing machine: eco 40", "washing machine", "eco 40", ()),
        ("alarm arm night", "alarm", "arm night", ()),
        ("hall lamp color warm white", "hall lamp", "color warm white", ()),
        ("hall lamp level to 40 %", "hall lamp", "level to 40 %", ()),
        ("heater set heating setpoint to 21", "heater", "set heating setpoint to 21", ()),
        ("kitchen heat to 16 °C", "kitchen heat", "16 °C", ()),
        ("kitchen heat off", "kitchen heat", "off", ()),
        ("kitchen heat heating, 21 °C", "kitchen heat", "heating, 21 °C", ()),
        ("hall thermostat heating, 21 °C", "hall thermostat", "heating, 21 °C", ()),
        ("hall thermostat cool", "hall thermostat", "cool", ()),
        ("water level sensor on", "water level sensor", "on", ()),
        ("lamp and fan on", "lamp and fan", "on", ()),
        ("lamps that are on and dimmable off", "lamps that are on and dimmable", "off", ()),
        ("plugs with power off", "plugs with power", "off", ()),
    ],
)
def test_a_command_ends_with_what_devices_take(
    text: str, target: str, command: str, values: tuple[tuple[str, str], ...]
) -> None:
    assert read_step(text) == Do(text, target, command, values)


def test_other_steps() -> None:
    assert read_step("notify The window is open") == Notify("The window is open")
    assert read_step("wait 5 minutes") == Wait(300.0)
    assert read_step("Undo") == Undo()
    found = read_step("wait until hall motion clear for 2m, at most 30m")
    assert isinstance(found, WaitUntil)
    assert (found.state.lasting, found.most) == (120.0, 1800.0)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("hall lamp onn", r"did you mean on\?$"),
        ("hall lamp on for 5m", "write three steps, 'hall lamp on', 'wait 5m' and 'undo'"),
        ("lamp on for 5", "write three steps, 'lamp on', 'wait 5s' and 'undo'"),
        ("hall lamp for 5m", "'hall lamp' is no step"),
        ("lamp on, then off", "write each as a step: 'lamp on' and 'lamp off'"),
        ("lamp on and fan off", "write each as a step: 'lamp on' and 'fan off'"),
        ("lamp on, wait 5m, lamp off", "'lamp on', 'wait 5m' and 'lamp off'"),
        ("lamp on over 5", "write 'lamp on, over 5s'"),
        ("lamp on, over 5", "like 'lamp on, over 5s'"),
        ("scene Film, over 5", "like 'scene Film, over 5s'"),
        ("lamp at 20%", "write 'lamp 20%'"),
        ("lamp on at 20%", "write 'lamp on, 20%'"),
        ("set heater to 21", "write the device first, like 'heater to 21'"),
        ("turn lamp on", "write the device first, like 'lamp on'"),
        ("open the blinds", "write the device first, like 'blinds open'"),
        ("hall lamp", "say what to do, such as on"),
        ("washer eco", "a device's own words follow a colon, as in 'washer: eco'"),
        ("hall lamp on 20 %", "write a comma after 'on'"),
        ("hall lamp on, over 5s, 20 %", "write 'over 5s' last"),
        ("turn on hall lamp", "write the device first, like 'hall lamp on'"),
        ("set hall lamp level to 40", "write the device first, like 'hall lamp level to 40'"),
        ("wait", "write it like 'wait 5m'"),
        ("wait 5", "like 'wait 5s'"),
        ("wait for 5m", "write 'wait 5m'"),
        ("wait until lamp on, at most 30", "at most 30m'"),
        ("wait until 22:00, at most 1h", "like 'hall motion occupied'"),
        ("wait until lamp on", "may last forever"),
        ("lamp on, open", "cannot follow"),
        ("lamp", "is no step"),
        ("front door: unlock code=1234", "no code is kept"),
    ],
)
def test_a_mistake_is_named(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        read_step(text)
