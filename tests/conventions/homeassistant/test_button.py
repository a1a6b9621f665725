import pytest

from homebot.conventions.description import Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_button, build_scene
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

IDENTIFY = {
    "command_topic": "zigbee2mqtt/lamp/set/identify",
    "device_class": "identify",
    "entity_category": "config",
    "payload_press": "identify",
}
RESTART = {"command_topic": "esp/button/restart/command", "device_class": "restart", "qos": 1}
EVENING = {"command_topic": "scenes/set", "payload_on": "evening", "command_template": "not for scenes"}


def test_a_button_is_pressed() -> None:
    part = build_button(DiscoveryConfig("button", "node_1", RESTART))
    assert [one.name for one in part.part.capabilities] == ["push"]
    assert part.codec.write("push", value=True) == (Publication("esp/button/restart/command", b"PRESS", qos=1),)
    assert part.part.writes == ("esp/button/restart/command",)


def test_a_button_that_identifies_can_be_told_to_locate() -> None:
    codec = build_button(DiscoveryConfig("button", "node_1", IDENTIFY)).codec
    published = (Publication("zigbee2mqtt/lamp/set/identify", b"identify"),)
    assert codec.write("push", value=True) == codec.write("locate", value=True) == published


def test_a_scene_is_called_by_its_payload() -> None:
    part = build_scene(DiscoveryConfig("scene", "node_1", EVENING))
    assert part.part.service_type == "x_scene"
    assert part.codec.write("scene", value=True) == (Publication("scenes/set", b"evening"),)


@pytest.mark.parametrize("value", [False, None, 1.0, "PRESS"])
def test_a_button_takes_nothing_but_true(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="only true"):
        build_button(DiscoveryConfig("button", "node_1", RESTART)).codec.write("push", value)


def test_a_button_without_a_topic_is_refused() -> None:
    with pytest.raises(WireError, match="command_topic"):
        build_button(DiscoveryConfig("button", "node_1", {}))
