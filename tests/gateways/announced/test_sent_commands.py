"""What the owner is shown of the commands of a part, and which changes of an announcement make it another one."""

import json
from typing import Any

import pytest

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.gateways.announced.sent_commands import MAX_LINES, sent_commands
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.things.formats.mqtt.reader import ThingReader
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

LOCK = {"unique_id": "u", "name": "Bolt", "command_topic": "door/set", "device": {"identifiers": ["door"]}}


def announced(component: str, **config: Any) -> DescribedPart:
    """The part that Home Assistant discovery announces."""
    reader = HomeAssistantDiscovery(HomeAssistantSettings())
    topic, payload = f"homeassistant/{component}/door/config", json.dumps({**LOCK, **config}).encode()
    (device,) = reader.read_message(topic, payload, retained=False)
    assert isinstance(device, DeviceAnnounced)
    (part,) = device.parts
    return part


def z2m_lock(**feature: Any) -> DescribedPart:
    state = {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "LOCK"}
    features = [{**state, "value_off": "UNLOCK", **feature}]
    definition = {"model": "m", "vendor": "v", "exposes": [{"type": "lock", "features": features}]}
    entry = {
        "ieee_address": "0x0000000000000001",
        "friendly_name": "d",
        "type": "Router",
        "supported": True,
        "definition": definition,
    }
    payload = json.dumps([entry]).encode()
    (device,) = Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    assert isinstance(device, DeviceAnnounced)
    return device.parts[0]


def thing_lock(**form: Any) -> DescribedPart:
    forms = [{"href": "mqtt://b/door/set", "op": ["writeproperty"], "mqv:topic": "door/set", **form}]
    description = {
        "@context": "https://www.w3.org/2022/wot/td/v1.1",
        "title": "Door",
        "security": "n",
        "securityDefinitions": {"n": {"scheme": "nosec"}},
        "properties": {"lock": {"type": "boolean", "forms": forms}},
    }
    (device,) = ThingReader(("things",)).read_message("things/door/td", json.dumps(description).encode(), retained=True)
    assert isinstance(device, DeviceAnnounced)
    return device.parts[0]


def test_a_lock_is_shown_with_each_setting_topic_and_payload() -> None:
    lock = announced("lock", payload_lock="OPEN", retain=True)
    assert list(sent_commands(lock)) == [
        "Bolt: lock=locked: door/set OPEN (retained)",
        "Bolt: lock=unlocked: door/set UNLOCK (retained)",
    ]


def test_a_lock_with_a_code_is_shown_with_a_code_in_its_place() -> None:
    lock = announced("lock", code_format="^\\d{4}$", command_template="{{ value }} {{ code }}")
    assert list(sent_commands(lock)) == [
        "Bolt: lock=locked: door/set LOCK CODE",
        "Bolt: lock=unlocked: door/set UNLOCK CODE",
    ]


def test_an_alarm_does_not_show_its_code() -> None:
    alarm = announced("alarm_control_panel", state_topic="s", code="4711", code_arm_required=False)
    lines = list(sent_commands(alarm))
    assert "Bolt: alarm=disarmed: it takes a code, which is not shown" in lines
    assert "Bolt: alarm=armed_away: door/set ARM_AWAY" in lines
    assert "4711" not in str(lines)


def test_the_lines_of_numbers_choices_and_long_payloads_are_bounded() -> None:
    assert list(sent_commands(announced("number", min=5, max=75, command_template="{{ value }} C"))) == [
        "Bolt: number=75: door/set 75 C"
    ]
    options = [f"option {number}" for number in range(MAX_LINES + 3)]
    lines = list(sent_commands(announced("select", options=options, command_template="x" * 1000)))
    assert len(lines) == MAX_LINES + 1
    assert lines[0] == f"Bolt: option=option 0: door/set {'x' * 200}… (1,000 bytes)"
    assert lines[-1] == "Bolt: and 3 further settings"


def test_a_codec_that_remembers_commands_is_not_tried() -> None:
    lamp = announced("light", rgb_command_topic="rgb", state_topic="s")
    assert list(sent_commands(lamp)) == ["Bolt: door/set, rgb: what is sent depends on what the device reported"]


@pytest.mark.parametrize(
    "change",
    [
        {"payload_unlock": "LOCK"},
        {"payload_open": "OPEN"},
        {"command_template": "LOCK"},
        {"retain": True},
        {"code_format": "."},
    ],
)
def test_another_payload_is_another_digest(change: dict[str, Any]) -> None:
    assert announced("lock").part.payloads != announced("lock", **change).part.payloads


@pytest.mark.parametrize(
    "change",
    [
        {"name": "Front door"},
        {"device": {"identifiers": ["door"], "sw_version": "2.0"}},
        {"state_topic": "door/state", "value_template": "{{ value_json.x }}", "state_locked": "on"},
        {"availability_topic": "a", "payload_available": "yes", "icon": "mdi:door", "origin": {"name": "x"}},
    ],
)
def test_shown_and_reported_properties_change_no_digest(change: dict[str, Any]) -> None:
    assert announced("lock").part.payloads == announced("lock", **change).part.payloads


def test_the_digest_of_an_alarm_does_not_follow_from_its_code() -> None:
    one, other = (announced("alarm_control_panel", state_topic="s", code=code) for code in ("4711", "0815"))
    assert one.part.payloads == other.part.payloads


def test_a_cover_that_is_sent_other_positions_has_another_digest() -> None:
    cover = {"set_position_topic": "door/position", "device_class": "gate"}
    same = announced("cover", **cover, position_topic="p", position_template="{{ value }}")
    upside_down = announced("cover", **cover, set_position_template="{{ 100 - position }}")
    assert announced("cover", **cover).part.payloads == same.part.payloads != upside_down.part.payloads
    assert "Bolt: position=100: door/position 0" in sent_commands(upside_down)


def test_an_alarm_that_takes_no_code_any_more_has_another_digest() -> None:
    coded = announced("alarm_control_panel", state_topic="s", code="4711")
    assert coded.part.payloads != announced("alarm_control_panel", state_topic="s").part.payloads


def test_the_values_of_a_zigbee_lock_are_in_its_digest() -> None:
    assert list(sent_commands(z2m_lock()))[:2] == [
        'lock: lock=locked: zigbee2mqtt/d/set {"state":"LOCK"}',
        'lock: lock=unlocked: zigbee2mqtt/d/set {"state":"UNLOCK"}',
    ]
    assert z2m_lock().part.payloads == z2m_lock(description="another text").part.payloads
    assert z2m_lock().part.payloads != z2m_lock(value_off="LOCK").part.payloads


def test_the_forms_of_a_thing_are_in_its_digest() -> None:
    assert thing_lock().part.payloads
    assert thing_lock().part.payloads != thing_lock(**{"mqv:retain": True}).part.payloads


def test_a_part_that_only_reports_has_no_digest() -> None:
    assert announced("sensor", state_topic="s").part.payloads == ""
