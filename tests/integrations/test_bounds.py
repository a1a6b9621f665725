"""What a device takes at most and at least is taken, whatever unit it counts in, and is read back as such.

The devices here are random, in the conventions that have bounds: each is told its bounds, and says what it was told.
"""

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.integrations.announced_parts import homeassistant_part, homie_part, thing_part, zigbee2mqtt_part
from tests.sizes import examples

from homebot.conventions.description import DescribedPart
from homebot.devices.part import Capability
from homebot.errors import RefusedError

pytestmark = pytest.mark.slow

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class Bounded:
    """A device with bounds.

    Attributes:
        part: Its part.
        capability: What has bounds.
        outside: The bounds that it announced, in the vocabulary's unit, as a person rounds them.
        says: What it says, topic and payload, for a number in its own unit.
    """

    part: DescribedPart
    capability: str
    outside: tuple[float, ...]
    says: Callable[[float], tuple[str, str]]

    @property
    def described(self) -> Capability:
        (found,) = [one for one in self.part.part.capabilities if one.name == self.capability]
        return found

    def told(self, value: float) -> float:
        """What it is told of *value*, in its own unit."""
        published = self.part.codec.write(self.capability, value)
        texts = [one.payload.decode() for one in published if NUMBER.search(one.payload.decode())]
        (number,) = NUMBER.findall(texts[0])
        return float(number)

    def read(self, number: float) -> float:
        topic, payload = self.says(number)
        value = self.part.codec.read(topic, payload.encode(), retained=False)[self.capability]
        assert isinstance(value, float)
        return value


def spread(low: float, high: float, *, whole: bool = False) -> st.SearchStrategy[tuple[float, float]]:
    numbers: st.SearchStrategy[float] = st.integers(math.ceil(low), math.floor(high)).map(float)
    if not whole:
        numbers |= st.floats(low, high).map(lambda one: round(one, 2))
    return st.tuples(numbers, numbers).filter(lambda ends: ends[0] < ends[1])


def kelvins_of(mireds: tuple[float, float], *, as_told: Callable[[float], int]) -> tuple[float, ...]:
    """The two ends in whole kelvin, as they stand on the box: those that are within when told in whole mired."""
    ends = tuple(round(1_000_000 / one) for one in reversed(mireds))
    low, high = (math.floor(one) for one in mireds)
    return tuple(float(one) for one in ends if low <= as_told(1_000_000 / one) <= high)


@st.composite
def homeassistant_lamps(draw: st.DrawFn) -> Bounded:
    mireds = draw(spread(100, 700))
    in_kelvin = draw(st.booleans())
    config = {
        "command_topic": "t/set",
        "state_topic": "t",
        "schema": "json",
        "supported_color_modes": ["color_temp"],
        "min_mireds": mireds[0],
        "max_mireds": mireds[1],
        "color_temp_kelvin": in_kelvin,
    }

    def says(number: float) -> tuple[str, str]:
        return "t", json.dumps({"state": "ON", "color_mode": "color_temp", "color_temp": number})

    outside = kelvins_of(mireds, as_told=math.floor)
    return Bounded(homeassistant_part("color_temperature", "light", config), "color_temperature", outside, says)


@st.composite
def zigbee2mqtt_lamps(draw: st.DrawFn) -> Bounded:
    mireds = draw(spread(100, 700))
    state = {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"}
    white = {
        "type": "numeric",
        "name": "color_temp",
        "property": "color_temp",
        "access": 7,
        "value_min": mireds[0],
        "value_max": mireds[1],
    }
    part = zigbee2mqtt_part("color_temperature", {"type": "light", "features": [state, white]})
    return Bounded(
        part,
        "color_temperature",
        kelvins_of(mireds, as_told=math.floor),
        lambda number: ("zigbee2mqtt/a", json.dumps({"color_temp": number})),
    )


@st.composite
def homie_lamps(draw: st.DrawFn) -> Bounded:
    is_kelvin = draw(st.booleans())
    ends = draw(spread(1500, 9000) if is_kelvin else spread(100, 700))
    white = {
        "datatype": draw(st.sampled_from(["float", "integer"])),
        "format": f"{ends[0]:g}:{ends[1]:g}",
        "unit": "K" if is_kelvin else "mired",
        "settable": True,
    }
    outside: tuple[float, ...] = ends if is_kelvin else ()
    if white["datatype"] == "integer":
        ends = draw(spread(1500, 9000, whole=True) if is_kelvin else spread(100, 700, whole=True))
        white["format"] = f"{ends[0]:g}:{ends[1]:g}"
        outside = ends if is_kelvin else tuple(float(round(1_000_000 / one)) for one in reversed(ends))
    part = homie_part(
        "color_temperature", {"on": {"datatype": "boolean", "settable": True}, "color-temperature": white}, "light"
    )
    return Bounded(
        part, "color_temperature", outside, lambda number: ("homie/5/x/n/color-temperature", _spelled(number))
    )


@st.composite
def things_of_white(draw: st.DrawFn) -> Bounded:
    mireds = draw(spread(100, 700, whole=True))
    schema = {"type": "integer", "unit": "mired", "minimum": mireds[0], "maximum": mireds[1]}
    part = thing_part("color_temperature", "ColorTemperatureProperty", schema)
    outside = tuple(float(round(1_000_000 / one)) for one in reversed(mireds))
    return Bounded(part, "color_temperature", outside, lambda number: ("t", json.dumps(number)))


@st.composite
def thermostats(draw: st.DrawFn) -> Bounded:
    is_fahrenheit = draw(st.booleans())
    ends = draw(spread(40, 100) if is_fahrenheit else spread(5, 35))
    config = {
        "temperature_command_topic": "t/set",
        "temperature_state_topic": "t",
        "modes": ["off", "heat"],
        "min_temp": ends[0],
        "max_temp": ends[1],
        "temperature_unit": "F" if is_fahrenheit else "C",
    }
    part = homeassistant_part("heating_setpoint", draw(st.sampled_from(["climate", "water_heater"])), config)
    return Bounded(part, "heating_setpoint", outside_of(ends, is_fahrenheit), lambda number: ("t", str(number)))


@st.composite
def homie_thermostats(draw: st.DrawFn) -> Bounded:
    is_fahrenheit = draw(st.booleans())
    span = (40, 55, 80, 100) if is_fahrenheit else (5, 12, 25, 35)  # such as a room may have; others are no setpoints
    ends = (draw(spread(*span[:2]))[0], draw(spread(*span[2:]))[1])
    target = {
        "datatype": "float",
        "format": f"{ends[0]:g}:{ends[1]:g}",
        "unit": "°F" if is_fahrenheit else "°C",
        "settable": True,
    }
    measured = {"datatype": "float", "unit": target["unit"]}
    part = homie_part("heating_setpoint", {"set-temperature": target, "temperature": measured}, "thermostat")
    says = ("homie/5/x/n/set-temperature", "{:f}")
    return Bounded(
        part, "heating_setpoint", outside_of(ends, is_fahrenheit), lambda number: (says[0], says[1].format(number))
    )


@st.composite
def things_of_temperature(draw: st.DrawFn) -> Bounded:
    is_fahrenheit = draw(st.booleans())
    ends = draw(spread(40, 100) if is_fahrenheit else spread(5, 35))
    unit = "fahrenheit" if is_fahrenheit else "celsius"
    schema = {"type": "number", "unit": unit, "minimum": ends[0], "maximum": ends[1]}
    part = thing_part("heating_setpoint", "TargetTemperatureProperty", schema)
    return Bounded(part, "heating_setpoint", outside_of(ends, is_fahrenheit), lambda number: ("t", json.dumps(number)))


@st.composite
def plain_numbers(draw: st.DrawFn) -> Bounded:
    ends = draw(spread(-1000, 1000))
    kind = draw(st.sampled_from(["homeassistant", "zigbee2mqtt", "homie", "thing"]))
    if kind == "homeassistant":
        config = {"command_topic": "t/set", "state_topic": "t", "min": ends[0], "max": ends[1]}
        return Bounded(
            homeassistant_part("number", "number", config), "number", ends, lambda number: ("t", str(number))
        )
    if kind == "zigbee2mqtt":
        expose = {"type": "numeric", "name": "x", "property": "x", "access": 7, "value_min": ends[0]}
        part = zigbee2mqtt_part("number", {**expose, "value_max": ends[1]})
        return Bounded(part, "number", ends, lambda number: ("zigbee2mqtt/a", json.dumps({"x": number})))
    if kind == "homie":
        prop = {"datatype": "float", "format": f"{ends[0]!r}:{ends[1]!r}", "settable": True}
        part = homie_part("number", {"x": prop})
        return Bounded(part, "number", ends, lambda number: ("homie/5/x/n/x", f"{number:f}"))
    schema = {"type": "number", "minimum": ends[0], "maximum": ends[1]}
    return Bounded(thing_part("number", "", schema), "number", ends, lambda number: ("t", json.dumps(number)))


def _spelled(number: float) -> str:
    return f"{number:f}".rstrip("0").rstrip(".")


def outside_of(ends: tuple[float, float], is_fahrenheit: bool) -> tuple[float, ...]:  # noqa: FBT001
    return tuple(round((one - 32) / 1.8, 1) for one in ends) if is_fahrenheit else ends


BOUNDED = {
    one.__name__: one
    for one in (
        homeassistant_lamps,
        zigbee2mqtt_lamps,
        homie_lamps,
        things_of_white,
        thermostats,
        homie_thermostats,
        things_of_temperature,
        plain_numbers,
    )
}


@pytest.mark.parametrize("name", BOUNDED)
@settings(max_examples=examples(40))
@given(data=st.data())
def test_each_bound_is_taken_and_read_back(name: str, data: st.DataObject) -> None:
    device = data.draw(BOUNDED[name]())
    low, high = device.described.bounds
    assert low < high
    for outside in (low, high, *device.outside):
        assert low <= outside <= high, "handles compare with the bounds that are described"
        back = device.read(device.told(outside))
        assert low <= back <= high
        assert device.read(device.told(back)) == back


@pytest.mark.parametrize("name", BOUNDED)
@settings(max_examples=examples(40))
@given(data=st.data())
def test_a_value_that_is_read_is_within_the_bounds(name: str, data: st.DataObject) -> None:
    """The device says its own bounds."""
    device = data.draw(BOUNDED[name]())
    for own in (device.told(one) for one in device.described.bounds):
        assert device.described.bounds[0] <= device.read(own) <= device.described.bounds[1]


README_LAMP: dict[str, Any] = {
    "command_topic": "t/set",
    "schema": "json",
    "supported_color_modes": ["color_temp"],
    "min_mirs": 153.85,
    "max_mirs": 370.37,
}


@pytest.mark.parametrize(("kelvin", "mired"), [(2700.0, 370), (6500.0, 153)])
def test_a_lamp_of_2700_to_6500_kelvin_takes_both(kelvin: float, mired: int) -> None:
    part = homeassistant_part("color_temperature", "light", README_LAMP)
    (white,) = [one for one in part.part.capabilities if one.name == "color_temperature"]
    assert white.bounds[0] <= kelvin <= white.bounds[1]
    (told,) = part.codec.write("color_temperature", kelvin)
    assert json.loads(told.payload) == {"state": "ON", "color_temp": mired}


@pytest.mark.parametrize("celsius", [7.1, 35.2])
def test_a_temperature_beyond_a_bound_is_refused(celsius: float) -> None:
    config = {"temperature_command_topic": "t/set", "temperature_unit": "F", "min_temp": 45, "max_temp": 95}
    with pytest.raises(RefusedError, match=r"7\.2 to 35 °C"):
        homeassistant_part("heating_setpoint", "climate", config).codec.write("heating_setpoint", celsius)
