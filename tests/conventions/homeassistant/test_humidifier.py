from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.appliances import build_humidifier
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

DRYER = {
    "command_topic": "dry/set",
    "state_topic": "dry/state",
    "state_value_template": "{{ value_json.power }}",
    "payload_on": "on",
    "payload_off": "off",
    "target_humidity_command_topic": "dry/target/set",
    "target_humidity_state_topic": "dry/target",
    "current_humidity_topic": "dry/now",
    "mode_command_topic": "dry/mode/set",
    "mode_state_topic": "dry/mode",
    "modes": ["normal", "laundry"],
    "payload_reset_mode": "-",
    "min_humidity": 35,
    "max_humidity": 80,
    "device_class": "dehumidifier",
}
BARE = {"command_topic": "h/set", "target_humidity_command_topic": "h/target"}


def humidifier(fields: Mapping[str, object]) -> DescribedPart:
    return build_humidifier(DiscoveryConfig("humidifier", "node_1", fields))


@pytest.mark.parametrize(
    ("topic", "said", "expected"),
    [
        ("dry/state", b'{"power": "on"}', {"on_off": True}),
        ("dry/state", b'{"power": null}', {"on_off": None}),
        ("dry/state", b'{"power": "maybe"}', {}),
        ("dry/target", b"49.6", {"humidity_setpoint": 50.0}),
        ("dry/target", b"90", {}),
        ("dry/target", b"None", {"humidity_setpoint": None}),
        ("dry/now", b"90", {"humidity": 90.0}),
        ("dry/now", b"101", {}),
        ("dry/mode", b"laundry", {"humidifier_mode": "laundry"}),
        ("dry/mode", b"-", {"humidifier_mode": None}),
        ("dry/mode", b"None", {}),
    ],
)
def test_a_topic_tells_one_thing(topic: str, said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert humidifier(DRYER).codec.read(topic, said, retained=False) == expected


@pytest.mark.parametrize(
    ("capability", "value", "topic", "payload"),
    [
        ("on_off", True, "dry/set", b"on"),
        ("humidity_setpoint", 45.0, "dry/target/set", b"45"),
        ("humidifier_mode", "normal", "dry/mode/set", b"normal"),
    ],
)
def test_it_is_told_as_home_assistant_does(capability: str, value: PlainValue, topic: str, payload: bytes) -> None:
    (publication,) = humidifier(DRYER).codec.write(capability, value)
    assert (publication.topic, publication.payload) == (topic, payload)


def test_one_that_says_nothing_is_told_all_the_same() -> None:
    part = humidifier(BARE)
    assert {(one.name, one.readable, one.settable) for one in part.part.capabilities} == {
        ("on_off", False, True),
        ("humidity_setpoint", False, True),
    }
    assert (part.part.tag, humidifier(DRYER).part.tag) == ("humidifier", "dehumidifier")


def test_a_humidity_out_of_bounds_is_refused() -> None:
    with pytest.raises(RefusedError, match="35 to 80"):
        humidifier(DRYER).codec.write("humidity_setpoint", 90.0)


@pytest.mark.parametrize(
    "fields",
    [
        {"command_topic": "h/set"},
        {"target_humidity_command_topic": "h"},
        {**BARE, "min_humidity": 50, "max_humidity": 50},
        {**BARE, "max_humidity": 120},
        {**BARE, "modes": ["None", "eco"], "mode_command_topic": "m"},
    ],
)
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        humidifier(fields)
