import json
from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_switch
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

ZIGBEE_PLUG = {
    "command_topic": "zigbee2mqtt/plug/set",
    "device_class": "outlet",
    "name": None,
    "payload_off": "OFF",
    "payload_on": "ON",
    "state_topic": "zigbee2mqtt/plug",
    "unique_id": "0x1_switch_zigbee2mqtt",
    "value_template": "{{ value_json['state'] }}",
}
CHILD_LOCK = {
    "command_topic": "z/trv/set/child_lock",
    "entity_category": "config",
    "payload_off": False,
    "payload_on": True,
    "state_topic": "z/trv",
    "unique_id": "0x2_child_lock",
    "value_template": "{{ value_json.child_lock }}",
}
BARE = {"command_topic": "relay/set"}


def switch(fields: Mapping[str, object]) -> DescribedPart:
    return build_switch(DiscoveryConfig("switch", "node_1", fields))


@pytest.mark.parametrize(
    ("fields", "said", "on"),
    [
        (ZIGBEE_PLUG, {"state": "ON"}, True),
        (ZIGBEE_PLUG, {"state": "OFF"}, False),
        (ZIGBEE_PLUG, {"state": None}, None),
        (CHILD_LOCK, {"child_lock": True}, True),
        (CHILD_LOCK, {"child_lock": False}, False),
    ],
)
def test_a_state_is_compared_as_python_spells_it(fields: Mapping[str, object], said: object, on: PlainValue) -> None:
    codec = switch(fields).codec
    assert codec.read(codec.topics()[0], json.dumps(said).encode(), retained=False) == {"on_off": on}


@pytest.mark.parametrize(
    "said", [b'{"state": "TOGGLE"}', b'{"power": 3}', b"", b"\xff", b"[", b'{"state":' + b"[" * 9999]
)
def test_what_is_no_state_changes_nothing(said: bytes) -> None:
    assert switch(ZIGBEE_PLUG).codec.read("zigbee2mqtt/plug", said, retained=False) == {}


def test_another_topic_tells_nothing() -> None:
    assert switch(ZIGBEE_PLUG).codec.read("zigbee2mqtt/other", b'{"state": "ON"}', retained=False) == {}


def test_an_outlet_is_a_plug_and_any_other_a_switch() -> None:
    assert switch(ZIGBEE_PLUG).part.service_type == "plug"
    assert switch(BARE).part.service_type == "switch"


def test_a_part_is_named_by_its_unique_id_and_else_by_its_discovery_id() -> None:
    assert switch(ZIGBEE_PLUG).part.id == "0x1_switch_zigbee2mqtt"
    assert switch(BARE).part.id == "node_1"


def test_a_switch_without_state_topic_cannot_be_read() -> None:
    (on_off,) = switch(BARE).part.capabilities
    assert (on_off.readable, on_off.settable) == (False, True)


@pytest.mark.parametrize(
    ("fields", "on", "publication"),
    [
        (ZIGBEE_PLUG, True, Publication("zigbee2mqtt/plug/set", b"ON")),
        (CHILD_LOCK, False, Publication("z/trv/set/child_lock", b"False")),
        ({**BARE, "qos": 1, "retain": True}, True, Publication("relay/set", b"ON", qos=1, retain=True)),
        ({**BARE, "command_template": "{{ value }}"}, False, Publication("relay/set", b"OFF")),
    ],
)
def test_a_command_is_what_home_assistant_publishes(
    fields: Mapping[str, object], on: PlainValue, publication: Publication
) -> None:
    assert switch(fields).codec.write("on_off", on) == (publication,)


@pytest.mark.parametrize(("capability", "value"), [("on_off", 1.0), ("on_off", None), ("level", 3.0), ("on_off", "ON")])
def test_what_a_switch_cannot_do_is_refused(capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        switch(BARE).codec.write(capability, value)


def test_an_unsupported_state_template_shows_the_payload_raw() -> None:
    part = switch({**ZIGBEE_PLUG, "value_template": "{{ states('sun.sun') }}"})
    assert part.codec.read("zigbee2mqtt/plug", b"ON\x07", retained=False) == {"raw": "ON"}
    assert [(one.name, one.readable) for one in part.part.capabilities] == [("raw", True), ("on_off", False)]


def test_an_unsupported_command_template_refuses_with_its_reason() -> None:
    with pytest.raises(RefusedError, match="template"):
        switch({**BARE, "command_template": "{{ states('sun.sun') }}"}).codec.write("on_off", value=True)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("command_topic", None),
        ("command_topic", ""),
        ("command_topic", "a/+/set"),
        ("command_topic", "a\x00b"),
        ("command_topic", {"a": 1}),
        ("command_topic", "\ud800"),
        ("state_topic", "a#"),
        ("payload_on", ["ON"]),
        ("qos", 3),
        ("retain", "perhaps"),
        ("value_template", {}),
        ("entity_category", "system"),
    ],
)
def test_a_field_of_the_wrong_kind_is_refused_by_name(field: str, value: object) -> None:
    with pytest.raises(WireError, match=f"{field}|topic"):
        switch({**ZIGBEE_PLUG, field: value})
