from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_event, build_tag, build_trigger
from homebot.devices.value import PlainValue
from homebot.errors import WireError

DOORBELL = {
    "state_topic": "doorbell/event/doorbell/state",
    "device_class": "doorbell",
    "event_types": ["press", "double_press", 3],
}
ZIGBEE_SINGLE = {
    "automation_type": "trigger",
    "payload": "single",
    "subtype": "single",
    "topic": "zigbee2mqtt/remote/action",
    "type": "action",
}
KNOB = {
    "automation_type": "trigger",
    "type": "button_short_press",
    "subtype": "turn_on",
    "topic": "knob",
    "value_template": "{{ value_json.event }}",
    "payload": 7,
}
ANY = {"automation_type": "trigger", "type": "button_double_press", "subtype": "button_1", "topic": "shelly/double"}
READER = {"topic": "tags/scanned", "value_template": "{{ value_json.UID }}"}


def event(fields: Mapping[str, object]) -> DescribedPart:
    return build_event(DiscoveryConfig("event", "node_1", fields))


def trigger(fields: Mapping[str, object]) -> DescribedPart:
    return build_trigger(DiscoveryConfig("device_automation", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (b'{"event_type": "press"}', {"press": "press"}),
        (b'{"event_type": "double_press", "duration": 3}', {"press": "double_press"}),
        (b'{"event_type": 3}', {"press": "3"}),
        (b'{"event_type": "long_press"}', {}),
        (b'{"event_type": null}', {}),
        (b'{"event": "press"}', {}),
        (b"press", {}),
        (b"", {}),
        (b"{}", {}),
    ],
)
def test_an_event_of_a_declared_type_is_told(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    part = event(DOORBELL)
    assert (part.part.service_type, part.part.tag) == ("generic_switch", "doorbell")
    assert part.codec.read("doorbell/event/doorbell/state", said, retained=False) == expected


@pytest.mark.parametrize(
    ("fields", "topic", "said", "press"),
    [
        (ZIGBEE_SINGLE, "zigbee2mqtt/remote/action", b"single", "single"),
        (KNOB, "knob", b'{"event": 7}', "button_short_press turn_on"),
        (ANY, "shelly/double", b"whatever", "button_double_press button_1"),
    ],
)
def test_a_remote_is_pressed(fields: Mapping[str, object], topic: str, said: bytes, press: str) -> None:
    part = trigger(fields)
    assert part.part.capabilities[0].options == (press,)
    assert part.codec.read(topic, said, retained=False) == {"press": press}


def test_another_payload_is_another_event() -> None:
    assert trigger(ZIGBEE_SINGLE).codec.read("zigbee2mqtt/remote/action", b"double", retained=False) == {}


def test_a_reader_tells_which_tag_it_read() -> None:
    part = build_tag(DiscoveryConfig("tag", "node_1", READER))
    assert part.part.service_type == "x_tag_reader"
    assert part.codec.read("tags/scanned", b'{"UID": "E9F35959"}', retained=False) == {"scan": "E9F35959"}
    assert part.codec.read("tags/scanned", b'{"UID": ""}', retained=False) == {}


def test_what_the_broker_had_kept_happened_before_and_is_not_told() -> None:
    assert event(DOORBELL).codec.read(DOORBELL["state_topic"], b'{"event_type": "press"}', retained=True) == {}  # type: ignore[arg-type] # the table has lists too
    assert trigger(ZIGBEE_SINGLE).codec.read("zigbee2mqtt/remote/action", b"single", retained=True) == {}
    reader = build_tag(DiscoveryConfig("tag", "node_1", READER))
    assert reader.codec.read("tags/scanned", b'{"UID": "E9F35959"}', retained=True) == {}


@pytest.mark.parametrize("missing", ["automation_type", "type", "subtype", "topic"])
def test_a_trigger_that_misses_something_is_refused(missing: str) -> None:
    with pytest.raises(WireError, match="device_automation"):
        trigger({key: value for key, value in ZIGBEE_SINGLE.items() if key != missing})


@pytest.mark.parametrize("missing", ["event_types", "state_topic"])
def test_an_event_that_misses_something_is_refused(missing: str) -> None:
    with pytest.raises(WireError, match=missing):
        event({key: value for key, value in DOORBELL.items() if key != missing})
