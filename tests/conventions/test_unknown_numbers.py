"""A sensor that failed says so in the place of its number: its value is then unknown, in whatever convention."""

import json
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.convention import Convention
from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.conventions.homie import Homie, HomieSettings
from homebot.conventions.payload import is_unknown, read_number
from homebot.conventions.shelly import Shelly, ShellySettings
from homebot.conventions.tasmota import TasmotaDiscovery, TasmotaSettings
from homebot.conventions.thesis import thesis_part
from homebot.conventions.zigbee2mqtt import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.devices.text.states import decode_text
from homebot.devices.value import PlainValue
from homebot.wot.mqtt import ThingDescriptions, ThingSettings

Read = Callable[[str], dict[str, PlainValue]]

WORDS = ["nan", "NaN", "-nan", "inf", "-inf", "Infinity", "1e999", "unavailable", "unknown", "None", "null"]
MAC = "2462AB000011"


def sensor(convention: Convention, *announced: tuple[str, object]) -> DescribedPart:
    """The part that measures a temperature, after the convention took what was *announced*."""
    heard = [
        one
        for topic, payload in announced
        for one in convention.read_message(
            topic, (payload if isinstance(payload, str) else json.dumps(payload)).encode(), retained=True
        )
    ]
    parts = [part for one in heard if isinstance(one, DeviceAnnounced) for part in one.parts]
    (found,) = [one for one in parts if "temperature" in {each.name for each in one.part.capabilities}]
    return found


def reader(part: DescribedPart, topic: str, payload: Callable[[str], str]) -> Read:
    return lambda said: dict(part.codec.read(topic, payload(said).encode(), retained=False))


def homeassistant() -> Read:
    config = {"state_topic": "t", "device_class": "temperature", "unit_of_measurement": "°C", "unique_id": "u"}
    part = sensor(HomeAssistantDiscovery(HomeAssistantSettings()), ("homeassistant/sensor/x/config", config))
    return reader(part, "t", str)


def homeassistant_in_json() -> Read:
    config = {
        "state_topic": "t",
        "value_template": "{{ value_json.t }}",
        "device_class": "temperature",
        "unit_of_measurement": "°F",
    }
    part = sensor(HomeAssistantDiscovery(HomeAssistantSettings()), ("homeassistant/sensor/x/config", config))
    return reader(part, "t", lambda said: json.dumps({"t": said}))


def zigbee2mqtt() -> Read:
    exposes = [{"type": "numeric", "name": "temperature", "property": "temperature", "access": 1, "unit": "°C"}]
    entry = {
        "ieee_address": "0x00158d0001abcdef",
        "friendly_name": "a",
        "type": "EndDevice",
        "supported": True,
        "interview_completed": True,
        "definition": {"model": "m", "vendor": "v", "description": "d", "exposes": exposes},
    }
    part = sensor(Zigbee2Mqtt(Zigbee2MqttSettings()), ("zigbee2mqtt/bridge/devices", [entry]))
    return reader(part, "zigbee2mqtt/a", lambda said: json.dumps({"temperature": said}))


def tasmota() -> Read:
    config = {"ver": 1, "mac": MAC, "dn": "D", "ft": "%prefix%/", "tp": ["c", "s", "t"], "rl": [], "lk": 1, "if": 0}
    leaves = {"ver": 1, "sn": {"SI7021": {"Temperature": 20.5}, "TempUnit": "C"}}
    part = sensor(
        TasmotaDiscovery(TasmotaSettings()),
        (f"tasmota/discovery/{MAC}/config", config),
        (f"tasmota/discovery/{MAC}/sensors", leaves),
    )
    return reader(part, "t/SENSOR", lambda said: json.dumps({"SI7021": {"Temperature": said}}))


def shelly() -> Read:
    announced = {"id": "shellyht-077A17", "model": "SHHT-1", "mac": "A8032A077A17"}
    part = sensor(Shelly(ShellySettings()), ("shellies/announce", announced))
    return reader(part, "shellies/shellyht-077A17/sensor/temperature", str)


def homie() -> Read:
    nodes = {"n": {"properties": {"temperature": {"datatype": "float", "unit": "°C"}}}}
    description = {"homie": "5.0", "version": 1, "nodes": nodes}
    part = sensor(Homie(HomieSettings()), ("homie/5/x/$description", description), ("homie/5/x/$state", "ready"))
    return reader(part, "homie/5/x/n/temperature", str)


def thing() -> Read:
    forms = [{"href": "mqtt://b", "op": "observeproperty", "mqv:filter": "t"}]
    description = {
        "@context": "https://www.w3.org/2022/wot/td/v1.1",
        "title": "T",
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": "nosec_sc",
        "properties": {"t": {"type": "number", "@type": "TemperatureProperty", "readOnly": True, "forms": forms}},
    }
    part = sensor(ThingDescriptions(ThingSettings()), ("homebot/things/x/td", description))
    return reader(part, "t", json.dumps)


def thesis() -> Read:
    part = thesis_part("temperatures", "h/temperatures/x/out", "h/temperatures/x/in")
    return lambda said: dict(decode_text(said, part))


CONVENTIONS = [homeassistant, homeassistant_in_json, zigbee2mqtt, tasmota, shelly, homie, thing, thesis]


@pytest.mark.parametrize("said", WORDS)
@pytest.mark.parametrize("make", CONVENTIONS)
def test_a_sensor_that_does_not_know_its_value_says_that_it_is_unknown(make: Callable[[], Read], said: str) -> None:
    assert make()(said) == {"temperature": None}


@pytest.mark.parametrize("said", ["", "warm", "21,5", "9" * 400])
@pytest.mark.parametrize("make", CONVENTIONS)
def test_what_is_neither_a_number_nor_unknown_changes_nothing(make: Callable[[], Read], said: str) -> None:
    assert make()(said) == {}


@given(st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=12) | st.sampled_from(WORDS))
def test_nothing_is_at_once_a_number_and_unknown(value: object) -> None:
    found = read_number("temperature", value)
    if is_unknown(value):
        assert found == {"temperature": None}
    else:
        assert found.get("temperature", 0.0) is not None
