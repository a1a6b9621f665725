"""Lists of a bridge in, devices out: joining, leaving, renaming, and whether they can be reached."""

import json
from typing import Any

import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import simple_house
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn, GroupsListed
from homebot.errors import WireError
from homebot.gateways.mqtt import MqttGatewaySettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.integrations.zigbee2mqtt.formats.bridge_device import StateAvailability
from homebot.integrations.zigbee2mqtt.formats.reader import MAX_BRIDGE_BYTES, MAX_DEVICES, _read

LAMP = "0x00158d0001abcdef"
PLUG = "0x00158d0001abcde0"
STATE = {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"}
SWITCH = {"type": "switch", "features": [STATE]}
SIDES = ("left", "right")
COORDINATOR = {"ieee_address": "0x00124b0000000001", "type": "Coordinator", "friendly_name": "Coordinator"}


def entry(ieee: str = LAMP, name: str = "kitchen/lamp", **more: Any) -> dict[str, Any]:
    definition = {"vendor": "IKEA", "model": "LED1545G12", "description": "Bulb E27", "exposes": [SWITCH]}
    return {
        "ieee_address": ieee,
        "friendly_name": name,
        "type": "Router",
        "power_source": "Mains (single phase)",
        "definition": definition,
        **more,
    }


def bridge(*bases: str) -> Zigbee2Mqtt:
    return Zigbee2Mqtt(Zigbee2MqttSettings(bases=bases or ("zigbee2mqtt",)))


def heard(convention: Zigbee2Mqtt, *entries: object, base: str = "zigbee2mqtt") -> tuple[AnnouncementEvent, ...]:
    return convention.read_message(f"{base}/bridge/devices", json.dumps(entries).encode(), retained=True)


def info(convention: Zigbee2Mqtt, config: object) -> tuple[AnnouncementEvent, ...]:
    return convention.read_message("zigbee2mqtt/bridge/info", json.dumps({"config": config}).encode(), retained=True)


def sources(device: DeviceAnnounced) -> list[str]:
    assert device.availability is not None
    return [source.topic for source in device.availability.sources]


def test_a_bridge_without_a_list_is_a_problem() -> None:
    """As where the list is larger than a broker may send."""
    convention = bridge("zigbee2mqtt", "attic")
    assert convention.problems() == ()
    info(convention, {})
    (trouble,) = convention.problems()
    assert trouble.startswith("zigbee2mqtt/bridge/info came, but zigbee2mqtt/bridge/devices did not")
    with pytest.raises(WireError):
        convention.read_message("zigbee2mqtt/bridge/devices", b"{", retained=True)
    assert convention.problems() == ()
    info(convention, {})
    assert convention.problems() == ()


def test_a_bridge_that_publishes_each_value_alone_is_in_trouble_until_it_is_set_up_otherwise() -> None:
    convention = bridge("zigbee2mqtt")
    convention.read_message("zigbee2mqtt/bridge/devices", b"[]", retained=True)
    info(convention, {"advanced": {"output": "attribute"}})
    (trouble,) = convention.problems()
    assert trouble.startswith("zigbee2mqtt publishes each value on a topic of its own")
    for output in ("attribute_and_json", "json"):
        info(convention, {"advanced": {"output": output}})
        assert convention.problems() == ()


def test_it_listens_to_the_settings_and_the_lists_of_each_bridge() -> None:
    assert bridge("zigbee2mqtt", "attic/z2m").filters() == (
        "zigbee2mqtt/bridge/info",
        "zigbee2mqtt/bridge/devices",
        "zigbee2mqtt/bridge/groups",
        "attic/z2m/bridge/info",
        "attic/z2m/bridge/devices",
        "attic/z2m/bridge/groups",
    )
    assert bridge().birth_messages() == ()


def test_a_device_is_described_with_its_address_topics_and_facts() -> None:
    device = device_in(heard(bridge(), COORDINATOR, entry()))
    assert (device.key, device.name, device.identifiers) == (LAMP, "kitchen/lamp", ("eui64:00158d0001abcdef",))
    assert device.facts == {
        "manufacturer": "IKEA",
        "model": "Bulb E27",
        "model_id": "LED1545G12",
        "power_source": "Mains (single phase)",
        "zigbee_type": "Router",
        "via_device": "zigbee2mqtt_bridge_0x00124b0000000001",
        "origin": "Zigbee2MQTT",
    }
    assert device.parts[0].part.reads == ("zigbee2mqtt/kitchen/lamp",)
    assert device.parts[0].part.writes == ("zigbee2mqtt/kitchen/lamp/set",)


def test_a_bridge_that_does_not_list_its_coordinator_is_known_by_its_base_topic() -> None:
    assert device_in(heard(bridge(), entry())).facts["via_device"] == "zigbee2mqtt_bridge_zigbee2mqtt"


def test_a_device_of_another_bridge_has_the_base_in_its_key_and_topics() -> None:
    device = device_in(heard(bridge("zigbee2mqtt", "attic"), entry(), base="attic"))
    assert (device.key, device.parts[0].part.reads) == (f"attic/{LAMP}", ("attic/kitchen/lamp",))


def test_a_device_that_is_missing_from_the_next_list_is_gone() -> None:
    convention = bridge()
    heard(convention, entry(), entry(PLUG, "plug"))
    gone, rest = heard(convention, entry(PLUG, "plug"))
    assert gone == DeviceWithdrawn(LAMP, "it left its bridge", is_final=True)
    assert isinstance(rest, DeviceAnnounced)
    assert rest.key == PLUG


def test_a_device_that_is_renamed_keeps_its_key_and_gets_new_topics() -> None:
    convention = bridge()
    heard(convention, entry())
    device = device_in(heard(convention, entry(name="hall/lamp")))
    assert (device.key, device.parts[0].part.reads) == (LAMP, ("zigbee2mqtt/hall/lamp",))


def test_a_list_that_is_removed_withdraws_its_devices_but_not_for_good() -> None:
    convention = bridge()
    heard(convention, entry())
    assert convention.read_message("zigbee2mqtt/bridge/devices", b"", retained=False) == (
        DeviceWithdrawn(LAMP, "its bridge's list was removed"),
    )
    assert convention.read_message("zigbee2mqtt/bridge/devices", b"", retained=False) == ()


def test_a_device_that_is_disabled_is_withdrawn_and_comes_back() -> None:
    convention = bridge()
    heard(convention, entry())
    assert heard(convention, entry(disabled=True)) == (DeviceWithdrawn(LAMP, "it was disabled, or its name was taken"),)
    assert device_in(heard(convention, entry())).key == LAMP


def test_a_device_unknown_to_the_bridge_shows_its_raw_messages() -> None:
    device = device_in(heard(bridge(), entry(definition=None, supported=False, interview_state="IN_PROGRESS")))
    (part,) = device.parts
    assert part.part.service_type == "x_unknown"
    assert part.codec.read("zigbee2mqtt/kitchen/lamp", b'{"a":1,"b":"x"}', retained=False) == {"raw": "a=1, b=x"}
    assert (device.facts["interview"], device.facts["supported"]) == ("in_progress", "no")


def test_a_broken_entry_costs_that_device_alone_and_is_counted() -> None:
    convention = bridge()
    names = ("a/+/b", "bridge/x", "", "kitchen/lamp/set", "a\x00", "n" * 600)
    broken = [{"ieee_address": "0x1"}, "lamp", None, *(entry(PLUG, name) for name in names)]
    *problems, lamp = heard(convention, *broken, entry())
    assert device_in((lamp,)).key == LAMP
    assert all(isinstance(one, WireError) for one in problems)
    assert len(problems) == convention.rejected == len(broken)


@pytest.mark.virtual_time
@pytest.mark.parametrize("address", ["0x1", 7, None])
async def test_the_log_names_the_entry_that_is_left_out_and_the_others_are_found(address: object) -> None:
    with capture_logs() as lines:
        async with simple_house(conventions=("zigbee2mqtt",)) as house:
            devices = [COORDINATOR, {**entry(name="attic"), "ieee_address": address}, entry(PLUG, "plug")]
            await house.say("zigbee2mqtt/bridge/devices", json.dumps(devices))
            assert [one.key for one in house.sighted()] == [f"zigbee2mqtt:{PLUG}"]
            assert house.gateway.counters.announcements_rejected == 1
    (line,) = [line for line in lines if line["event"] == "gateway.announcement_rejected"]
    assert f"'attic': ieee_address is {address!r}" in line["message"]


@pytest.mark.virtual_time
async def test_the_log_names_each_of_several_entries_that_are_left_out_once() -> None:
    with capture_logs() as lines:
        async with simple_house(conventions=("zigbee2mqtt",)) as house:
            devices = json.dumps([entry("0x1", "attic"), entry(LAMP, "lamp/set"), entry(PLUG, "plug")])
            await house.say("zigbee2mqtt/bridge/devices", devices)
            await house.say("zigbee2mqtt/bridge/devices", devices)
    attic, lamp = [line["message"] for line in lines if line["event"] == "gateway.announcement_rejected"]
    assert "'attic': ieee_address is '0x1'" in attic
    assert f"{LAMP}: friendly_name 'lamp/set'" in lamp


@pytest.mark.parametrize("name", [[], {}, 7, None])
def test_a_device_with_a_feature_without_a_name_does_not_cost_the_others(name: object) -> None:
    exposes = [{"type": "light", "features": [{**STATE, "name": name}]}]
    lamp, plug = heard(bridge(), entry(definition={"exposes": exposes}), entry(PLUG, "plug"))
    assert isinstance(lamp, DeviceAnnounced)
    assert isinstance(plug, DeviceAnnounced)


def test_a_device_with_a_broken_entry_stays() -> None:
    convention = bridge()
    heard(convention, entry(), entry(PLUG, "plug"))
    problem, lamp, plug = heard(convention, entry(name="#"), entry(PLUG, "plug"))
    assert isinstance(problem, WireError)
    assert isinstance(lamp, DeviceAnnounced)
    assert isinstance(plug, DeviceAnnounced)
    assert (lamp.key, lamp.name) == (LAMP, "kitchen/lamp")


def test_the_name_of_a_broken_entry_is_free_for_another() -> None:
    convention = bridge()
    heard(convention, entry())
    problem, gone, plug = heard(convention, entry(PLUG), entry(name="#"))
    assert isinstance(problem, WireError)
    assert gone == DeviceWithdrawn(LAMP, "it was disabled, or its name was taken")
    assert isinstance(plug, DeviceAnnounced)
    assert plug.key == PLUG


def test_devices_are_left_out_where_those_before_have_all_the_parts() -> None:
    with pytest.raises(WireError, match="already have 50000 parts, the limit"):
        _read("zigbee2mqtt", entry(), set(), is_known=False, room=0)


def test_a_repeated_name_or_address_is_left_out() -> None:
    convention = bridge()
    *problems, lamp = heard(convention, entry(), entry(PLUG), entry(name="other"))
    assert device_in((lamp,)).name == "kitchen/lamp"
    assert len(problems) == convention.rejected == 2


@pytest.mark.parametrize(
    "payload",
    [b"{}", b"nothing", b"[" * 9_999, json.dumps([{}] * (MAX_DEVICES + 1)).encode(), b'[{"ieee_address": "0x"}]'],
    ids=["object", "no json", "deep", "too many", "broken"],
)
def test_a_list_that_is_none_is_refused_and_nothing_changes(payload: bytes) -> None:
    convention = bridge()
    heard(convention, entry())
    with pytest.raises(WireError):
        convention.read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    assert convention.rejected == 1
    assert heard(convention) == (DeviceWithdrawn(LAMP, "it left its bridge", is_final=True),)


def test_other_topics_say_nothing() -> None:
    convention = bridge()
    for topic in ("zigbee2mqtt/lamp", "attic/bridge/devices", "zigbee2mqtt/bridge/state", "bridge/devices"):
        assert convention.read_message(topic, b"[1]", retained=True) == ()
    assert convention.read_message("zigbee2mqtt/bridge/info", b"", retained=True) == ()


def test_a_device_can_be_reached_when_bridge_and_device_say_so() -> None:
    device = device_in(heard(bridge(), entry()))
    assert sources(device) == ["zigbee2mqtt/bridge/state", "zigbee2mqtt/kitchen/lamp/availability"]
    assert device.availability is not None
    assert device.availability.mode == "all"


@pytest.mark.parametrize("off", [{}, {"availability": False}, {"availability": {"enabled": False}}])
def test_where_devices_do_not_tell_it_the_bridges_word_stands_alone(off: object) -> None:
    convention = bridge()
    assert info(convention, off) == ()
    assert sources(device_in(heard(convention, entry()))) == ["zigbee2mqtt/bridge/state"]


def test_devices_are_described_anew_when_it_is_learned_later_how_they_tell_it() -> None:
    convention = bridge()
    heard(convention, entry(), entry(PLUG, "plug"))
    config = {"availability": {"enabled": False}, "devices": {LAMP.upper(): {"availability": True}, "odd": 1}}
    assert sources(device_in(info(convention, config))) == ["zigbee2mqtt/bridge/state"]
    assert info(convention, config) == ()
    again = info(convention, {"availability": {"enabled": True}})
    assert {device.key for device in again if isinstance(device, DeviceAnnounced)} == {PLUG}


def groups_in(convention: Zigbee2Mqtt, *groups: object) -> dict[str, tuple[str, ...]]:
    payload = json.dumps(groups).encode()
    (listed,) = convention.read_message("zigbee2mqtt/bridge/groups", payload, retained=True)
    assert isinstance(listed, GroupsListed)
    return dict(listed.members)


def test_the_members_of_a_group_are_devices_or_parts_of_one_endpoint() -> None:
    """The group has the identifier with which Zigbee2MQTT 2.14.1 announces it to Home Assistant."""
    convention = bridge()
    exposes = [{**SWITCH, "endpoint": one, "features": [{**STATE, "property": f"state_{one}"}]} for one in SIDES]
    definition = {"vendor": "Aqara", "model": "QBKG03LM", "exposes": exposes}
    endpoints = {"1": {}, "2": {"name": "left"}, "3": {"name": "right"}}
    plug = entry(PLUG, "wall", definition=definition, endpoints=endpoints)
    assert [one.name for one in heard(convention, entry(), plug) if isinstance(one, DeviceAnnounced)][1] == "wall"
    members = [{"ieee_address": LAMP, "endpoint": 1}, {"ieee_address": PLUG, "endpoint": 3}, {"ieee_address": 7}, 8]
    assert groups_in(convention, {"id": 4, "friendly_name": "kitchen", "members": members}, {"id": 5}, "odd") == {
        "id:zigbee2mqtt_1221051039810110150109113116116_4": (
            "eui64:00158d0001abcdef",
            "eui64:00158d0001abcde0#switch_right",
        ),
        "id:zigbee2mqtt_1221051039810110150109113116116_5": (),
    }


def test_the_room_that_a_user_gave_a_device_for_home_assistant_is_its_room() -> None:
    convention = bridge()
    assert device_in(heard(convention, entry())).area == ""
    overrides = {"homeassistant": {"device": {"suggested_area": "Kitchen"}}}
    assert device_in(info(convention, {"availability": True, "devices": {LAMP: overrides}})).area == "Kitchen"
    assert device_in(heard(convention, entry())).area == "Kitchen"
    assert device_in(info(convention, {"availability": True, "devices": {LAMP: {"homeassistant": None}}})).area == ""


@pytest.mark.parametrize(("payload", "problem"), [(b"{}", "config is None"), (b"{", "JSON")])
def test_info_without_config_is_refused(payload: bytes, problem: str) -> None:
    convention = bridge()
    with pytest.raises(WireError, match=problem):
        convention.read_message("zigbee2mqtt/bridge/info", payload, retained=True)
    assert convention.rejected == 1


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        (b'{"state":"online"}', True),
        (b'{"state":"offline"}', False),
        (b"online", True),
        (b"offline", False),
        (b"", None),
        (b'{"state":1}', None),
        (b'"online"', None),
        (b"{" * 5_000, None),
    ],
)
def test_the_word_of_availability_is_an_object_or_plain(payload: bytes, expected: object) -> None:
    assert StateAvailability("t").read(payload) is expected


def test_the_largest_announcement_is_what_the_largest_list_may_be() -> None:
    assert MqttGatewaySettings().max_announcement == MAX_BRIDGE_BYTES
