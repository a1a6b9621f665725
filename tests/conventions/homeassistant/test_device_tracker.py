from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_device_tracker
from homebot.devices.value import PlainValue
from homebot.errors import WireError

THEENGS = {
    "state_topic": "+/+/BTtoMQTT/A4C138000011",
    "value_template": "{% if value_json.get('rssi') -%}home{%- else -%}not_home{%- endif %}",
    "source_type": "bluetooth_le",
}
PHONE = {"state_topic": "phone", "payload_home": "in", "payload_not_home": "out", "payload_reset": "?"}


def tracker(fields: Mapping[str, object]) -> DescribedPart:
    return build_device_tracker(DiscoveryConfig("device_tracker", "node_1", fields))


@pytest.mark.parametrize(
    ("fields", "topic", "said", "expected"),
    [
        (THEENGS, "home/gateway/BTtoMQTT/A4C138000011", b'{"rssi": -60}', {"place": "home"}),
        (THEENGS, "home/gateway/BTtoMQTT/A4C138000011", b'{"name": "x"}', {"place": "not_home"}),
        (PHONE, "phone", b"in", {"place": "home"}),
        (PHONE, "phone", b"out", {"place": "not_home"}),
        (PHONE, "phone", b"?", {"place": None}),
        (PHONE, "phone", b"Work", {"place": "Work"}),
        (PHONE, "phone", b"  ", {}),
    ],
)
def test_it_tells_the_place(
    fields: Mapping[str, object], topic: str, said: bytes, expected: Mapping[str, PlainValue]
) -> None:
    assert tracker(fields).codec.read(topic, said, retained=True) == expected


def test_how_it_knows_is_its_tag() -> None:
    assert (tracker(THEENGS).part.service_type, tracker(THEENGS).part.tag) == ("x_tracker", "bluetooth_le")


def test_one_that_tells_only_coordinates_is_known_without_a_place() -> None:
    assert tracker({"json_attributes_topic": "phone/attributes"}).part.capabilities == ()


def test_one_that_tells_nothing_is_refused() -> None:
    with pytest.raises(WireError, match="json_attributes_topic"):
        tracker({"source_type": "gps"})
