from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_update
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

ZIGBEE = {
    "command_topic": "zigbee2mqtt/bridge/request/device/ota_update/update",
    "device_class": "firmware",
    "entity_category": "config",
    "payload_install": '{"id": "0x1"}',
    "state_topic": "zigbee2mqtt/lamp",
    "value_template": "{\"latest_version\":\"{{ value_json['update']['latest_version'] }}\","
    "\"installed_version\":\"{{ value_json['update']['installed_version'] }}\"}",
}
PLAIN = {"state_topic": "v", "latest_version_topic": "v/latest", "latest_version_template": "{{ value_json.tag }}"}
OBJECT = {"state_topic": "v"}


def update(fields: Mapping[str, object]) -> DescribedPart:
    return build_update(DiscoveryConfig("update", "node_1", fields))


@pytest.mark.parametrize(
    ("fields", "topic", "said", "expected"),
    [
        (
            ZIGBEE,
            "zigbee2mqtt/lamp",
            b'{"update": {"installed_version": 99, "latest_version": 100}}',
            {"version": "99", "latest_version": "100", "update_available": True},
        ),
        (
            OBJECT,
            "v",
            b'{"installed_version": 100, "latest_version": 99}',
            {"version": "100", "latest_version": "99", "update_available": False},
        ),
        (
            OBJECT,
            "v",
            b'{"installed_version": "1.2b", "latest_version": "1.2b"}',
            {"version": "1.2b", "latest_version": "1.2b", "update_available": False},
        ),
        (
            OBJECT,
            "v",
            b'{"installed_version": "1.2b", "latest_version": "1.3"}',
            {"version": "1.2b", "latest_version": "1.3", "update_available": True},
        ),
        (OBJECT, "v", b'{"installed_version": "1.3"}', {"version": "1.3", "update_available": None}),
        (PLAIN, "v", b"1.4.0", {"version": "1.4.0"}),
        (PLAIN, "v", b"None", {"version": None}),
        (PLAIN, "v/latest", b'{"tag": "1.5.0"}', {"latest_version": "1.5.0"}),
        (PLAIN, "v", b"", {}),
        (PLAIN, "v", b"{}", {}),
        (PLAIN, "v", b'{"installed_version": [1]}', {}),
    ],
)
def test_versions_are_heard(
    fields: Mapping[str, object], topic: str, said: bytes, expected: Mapping[str, PlainValue]
) -> None:
    assert update(fields).codec.read(topic, said, retained=True) == expected


@pytest.mark.parametrize("capability", ["version", "update_available", "push"])
def test_it_is_never_told_to_install_anything(capability: str) -> None:
    part = update(ZIGBEE)
    assert not any(one.settable for one in part.part.capabilities)
    assert part.codec.topics() == ("zigbee2mqtt/lamp",)
    with pytest.raises(RefusedError, match="does not install software"):
        part.codec.write(capability, value=True)


def test_an_update_without_a_topic_is_refused() -> None:
    with pytest.raises(WireError, match="state_topic"):
        update({"latest_version_topic": "v"})
