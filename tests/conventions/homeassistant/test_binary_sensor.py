import json
from collections.abc import Mapping

import pytest

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_binary_sensor
from homebot.devices.value import PlainValue
from homebot.errors import WireError

ZIGBEE_DOOR = {
    "device_class": "door",
    "payload_off": True,
    "payload_on": False,
    "state_topic": "zigbee2mqtt/front",
    "unique_id": "0x1_contact_zigbee2mqtt",
    "value_template": '{{ value_json["contact"] }}',
}
ZWAVE_MOTION = {
    "payload_on": True,
    "payload_off": False,
    "value_template": "{{ value_json.value }}",
    "device_class": "motion",
    "state_topic": "zwave/motion/113/0/Motion",
}
SHELLY_MOTION = {"state_topic": "shellies/pir/motion", "payload_on": 1, "device_class": "motion", "off_delay": 30}
PLAIN = {"state_topic": "b"}


def sensor(fields: Mapping[str, object]) -> DescribedPart:
    return build_binary_sensor(DiscoveryConfig("binary_sensor", "node_1", fields))


def heard(fields: Mapping[str, object], said: object) -> Mapping[str, PlainValue]:
    codec = sensor(fields).codec
    payload = said if isinstance(said, str) else json.dumps(said)
    return codec.read(codec.topics()[0], payload.encode(), retained=True)


@pytest.mark.parametrize(
    ("fields", "said", "expected"),
    [
        (ZIGBEE_DOOR, {"contact": False}, {"contact": True}),
        (ZIGBEE_DOOR, {"contact": True}, {"contact": False}),
        (ZIGBEE_DOOR, {"contact": None}, {"contact": None}),
        (ZWAVE_MOTION, {"value": True}, {"occupancy": True}),
        (SHELLY_MOTION, "1", {"occupancy": True}),
        (PLAIN, "ON", {"state": True}),
        (PLAIN, "OFF", {"state": False}),
        (PLAIN, "None", {"state": None}),
        (PLAIN, "on", {}),
        (PLAIN, "", {}),
        (ZIGBEE_DOOR, {"battery": 3}, {}),
        (ZIGBEE_DOOR, {"contact": [1]}, {}),
    ],
)
def test_words_are_compared_as_python_spells_them(
    fields: Mapping[str, object], said: object, expected: Mapping[str, PlainValue]
) -> None:
    assert heard(fields, said) == expected


@pytest.mark.parametrize(
    ("device_class", "service_type", "capability"),
    [
        ("door", "contact_sensor", "contact"),
        ("window", "contact_sensor", "contact"),
        ("opening", "contact_sensor", "contact"),
        ("garage_door", "contact_sensor", "contact"),
        ("motion", "occupancy_sensor", "occupancy"),
        ("occupancy", "occupancy_sensor", "occupancy"),
        ("presence", "occupancy_sensor", "occupancy"),
        ("smoke", "smoke_co_alarm", "smoke"),
        ("carbon_monoxide", "smoke_co_alarm", "carbon_monoxide_alarm"),
        ("gas", "smoke_co_alarm", "gas"),
        ("moisture", "water_leak_detector", "water_leak"),
        ("cold", "water_freeze_detector", "freeze"),
        ("battery", "x_battery", "battery_low"),
        ("lock", "x_binary_sensor", "unlocked"),
        ("tamper", "x_binary_sensor", "tamper"),
        ("mood", "x_binary_sensor", "state"),
        (None, "x_binary_sensor", "state"),
    ],
)
def test_its_class_says_what_on_means(device_class: str | None, service_type: str, capability: str) -> None:
    part = sensor({**PLAIN, "device_class": device_class})
    assert (part.part.service_type, part.part.tag) == (service_type, device_class or "")
    assert part.codec.read("b", b"ON", retained=False) == {capability: True}


def test_a_sensor_that_says_only_on_is_off_after_its_delay() -> None:
    assert sensor(SHELLY_MOTION).expiries == (AutoExpiry("occupancy", 30.0, value=False, only=True),)


def test_a_sensor_that_expires_is_unknown_then() -> None:
    assert sensor({**PLAIN, "expire_after": 5}).expiries == (AutoExpiry("state", 5.0),)


@pytest.mark.parametrize("fields", [{}, {**PLAIN, "off_delay": -1}, {**PLAIN, "payload_on": {}}])
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        sensor(fields)
