from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_select
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

POWER_ON = {
    "command_topic": "zigbee2mqtt/lamp/set/power_on_behavior",
    "entity_category": "config",
    "options": ["off", "on", "toggle", "previous"],
    "state_topic": "zigbee2mqtt/lamp",
    "value_template": '{{ value_json["power_on_behavior"] }}',
}
EFFECT = {"command_topic": "lamp/effect", "options": ["blink", "none", True], "retain": True}


def select(fields: Mapping[str, object]) -> DescribedPart:
    return build_select(DiscoveryConfig("select", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (b'{"power_on_behavior": "previous"}', {"option": "previous"}),
        (b'{"power_on_behavior": null}', {"option": None}),
        (b'{"power_on_behavior": "nOnE"}', {"option": None}),
        (b'{"power_on_behavior": "dim"}', {}),
        (b'{"power_on_behavior": ""}', {}),
        (b"{}", {}),
    ],
)
def test_only_an_option_is_heard(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert select(POWER_ON).codec.read("zigbee2mqtt/lamp", said, retained=True) == expected


def test_an_option_is_told() -> None:
    (publication,) = select(POWER_ON).codec.write("option", "toggle")
    assert (publication.topic, publication.payload) == ("zigbee2mqtt/lamp/set/power_on_behavior", b"toggle")


def test_an_option_that_is_no_text_is_one_as_python_spells_it() -> None:
    part = select(EFFECT)
    assert part.part.capabilities[0].options == ("blink", "none", "True")
    assert not part.part.capabilities[0].readable
    (publication,) = part.codec.write("option", "True")
    assert (publication.payload, publication.retain) == (b"True", True)


def test_a_setting_is_in_the_category_of_its_config() -> None:
    assert (select(POWER_ON).part.service_type, select(POWER_ON).part.category) == ("x_setting", "config")


def test_another_option_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RefusedError, match="off, on, toggle, previous"):
        select(POWER_ON).codec.write("option", "dim")


@pytest.mark.parametrize(
    "fields", [{"command_topic": "c"}, {"options": ["a"]}, {"command_topic": "c", "options": [[]]}]
)
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        select(fields)
