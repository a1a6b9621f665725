"""A sensor that failed says so in the place of its number: its value is then unknown, in whatever convention."""

import json
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.integrations.announced_parts import (
    homeassistant_part,
    homie_part,
    installed,
    part_with,
    thing_part,
    zigbee2mqtt_part,
)

from homebot.conventions.description import DescribedPart
from homebot.conventions.installed_conventions import find_conventions
from homebot.conventions.payload import is_unknown, read_number
from homebot.devices.value import PlainValue

Read = Callable[[str], dict[str, PlainValue]]

WORDS = ["nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e999", "unavailable", "unknown", "None", "null"]
MAC = "2462AB000011"


def reader(part: DescribedPart, topic: str, payload: Callable[[str], str]) -> Read:
    return lambda said: dict(part.codec.read(topic, payload(said).encode(), retained=False))


def homeassistant() -> Read:
    config = {"state_topic": "t", "device_class": "temperature", "unit_of_measurement": "°C", "unique_id": "u"}
    return reader(homeassistant_part("temperature", "sensor", config), "t", str)


def homeassistant_in_json() -> Read:
    config = {
        "state_topic": "t",
        "value_template": "{{ value_json.t }}",
        "device_class": "temperature",
        "unit_of_measurement": "°F",
    }
    return reader(homeassistant_part("temperature", "sensor", config), "t", lambda said: json.dumps({"t": said}))


def zigbee2mqtt() -> Read:
    expose = {"type": "numeric", "name": "temperature", "property": "temperature", "access": 1, "unit": "°C"}
    part = zigbee2mqtt_part("temperature", expose)
    return reader(part, "zigbee2mqtt/a", lambda said: json.dumps({"temperature": said}))


def tasmota() -> Read:
    config = {"ver": 1, "mac": MAC, "dn": "D", "ft": "%prefix%/", "tp": ["c", "s", "t"], "rl": [], "lk": 1, "if": 0}
    leaves = {"ver": 1, "sn": {"SI7021": {"Temperature": 20.5}, "TempUnit": "C"}}
    part = part_with(
        "temperature",
        installed("tasmota"),
        (f"tasmota/discovery/{MAC}/config", config),
        (f"tasmota/discovery/{MAC}/sensors", leaves),
    )
    return reader(part, "t/SENSOR", lambda said: json.dumps({"SI7021": {"Temperature": said}}))


def shelly() -> Read:
    device = {"id": "shellyht-077A17", "model": "SHHT-1", "mac": "A8032A077A17"}
    part = part_with("temperature", installed("shelly"), ("shellies/announce", device))
    return reader(part, "shellies/shellyht-077A17/sensor/temperature", str)


def homie() -> Read:
    part = homie_part("temperature", {"temperature": {"datatype": "float", "unit": "°C"}})
    return reader(part, "homie/5/x/n/temperature", str)


def thing() -> Read:
    part = thing_part("temperature", "TemperatureProperty", {"type": "number", "readOnly": True})
    return reader(part, "t", json.dumps)


def thesis() -> Read:
    (convention,) = find_conventions(("thesis",), {}, "h")
    return reader(part_with("temperature", convention, ("h/temperatures/x/out", "20")), "h/temperatures/x/out", str)


CONVENTIONS = {
    homeassistant: "homeassistant",
    homeassistant_in_json: "homeassistant",
    zigbee2mqtt: "zigbee2mqtt",
    tasmota: "tasmota",
    shelly: "shelly",
    homie: "homie",
    thing: "things",
    thesis: "thesis",
}


@pytest.mark.parametrize(
    "make", [pytest.param(make, marks=pytest.mark.rooms(folder)) for make, folder in CONVENTIONS.items()]
)
def test_a_sensor_that_does_not_know_its_value_says_that_it_is_unknown(make: Callable[[], Read]) -> None:
    """What is neither a number nor a word for unknown changes nothing."""
    assert {said: make()(said) for said in WORDS} == {said: {"temperature": None} for said in WORDS}
    odd = ("", "warm", "21,5", "9" * 400)
    assert {said: make()(said) for said in odd} == {said: {} for said in odd}


@given(st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=12) | st.sampled_from(WORDS))
def test_nothing_is_at_once_a_number_and_unknown(value: object) -> None:
    found = read_number("temperature", value)
    if is_unknown(value):
        assert found == {"temperature": None}
    else:
        assert found.get("temperature", 0.0) is not None
