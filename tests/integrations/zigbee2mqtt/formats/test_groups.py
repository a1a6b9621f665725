"""Groups of a bridge: what their members have in common, reached by one message."""

import json
from typing import Any

import pytest
from tests.integrations.announced_parts import device_in
from tests.integrations.zigbee2mqtt.formats.test_convention import (
    LAMP,
    PLUG,
    SIDES,
    STATE,
    SWITCH,
    bridge,
    entry,
    heard,
)

from homebot.conventions.description import (
    AnnouncementEvent,
    AsksMembers,
    DeviceAnnounced,
    DeviceWithdrawn,
    GroupsListed,
    Publication,
)
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt

BRIGHTNESS = {"type": "numeric", "name": "brightness", "property": "brightness", "access": 7}
WHITE = {"type": "numeric", "name": "color_temp", "property": "color_temp", "access": 7, "unit": "mired"}


def lamp(ieee: str, name: str, *features: dict[str, Any], **more: Any) -> dict[str, Any]:
    exposes = [{"type": "light", "features": [STATE, *features]}]
    return entry(ieee, name, definition={"vendor": "IKEA", "model": "LED", "exposes": exposes}, **more)


def group(*members: object, number: int = 4, **more: object) -> dict[str, object]:
    listed = [{"ieee_address": one, "endpoint": 1} if isinstance(one, str) else one for one in members]
    return {"id": number, "friendly_name": f"group {number}", "members": listed, **more}


def groups(convention: Zigbee2Mqtt, *entries: object, base: str = "zigbee2mqtt") -> list[AnnouncementEvent]:
    events = convention.read_message(f"{base}/bridge/groups", json.dumps(entries).encode(), retained=True)
    return [one for one in events if isinstance(one, DeviceAnnounced | DeviceWithdrawn)]


def test_a_group_of_lamps_is_a_lamp_that_says_what_it_has_not_heard() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling", BRIGHTNESS, WHITE), lamp(PLUG, "shelf", BRIGHTNESS))
    device = device_in(groups(convention, group(LAMP, PLUG)))
    (part,) = device.parts
    assert (device.key, device.name, device.owns) == ("group/4", "group 4", ("zigbee2mqtt/group 4",))
    assert part.part.members == ("eui64:00158d0001abcdef", "eui64:00158d0001abcde0")
    assert part.part.service_type == "light"
    assert {one.name: (one.settable, one.echoed) for one in part.part.capabilities} == {
        "on_off": (True, True),
        "level": (True, True),
    }
    assert part.state_requests == ()


def test_a_group_of_lamps_and_plugs_is_turned_on_and_off() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling", BRIGHTNESS), entry(PLUG, "plug"))
    (part,) = device_in(groups(convention, group(LAMP, PLUG))).parts
    assert (part.part.id, [one.name for one in part.part.capabilities]) == ("switch", ["on_off"])


def test_the_members_are_asked_for_what_a_command_changes() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling", BRIGHTNESS), lamp(PLUG, "shelf", BRIGHTNESS))
    (part,) = device_in(groups(convention, group(LAMP, PLUG))).parts
    sent = part.codec.write("level", 50.0, transition=2.0)
    assert sent == (Publication("zigbee2mqtt/group 4/set", b'{"state":"ON","brightness":127,"transition":2}'),)
    assert isinstance(part.codec, AsksMembers)
    question = b'{"state":"","brightness":""}'
    assert part.codec.questions(sent) == (
        Publication("zigbee2mqtt/ceiling/get", question),
        Publication("zigbee2mqtt/shelf/get", question),
    )


def test_a_white_is_set_within_the_bounds_that_all_have() -> None:
    convention = bridge()
    whites = ({"value_min": 150, "value_max": 500}, {"value_min": 250, "value_max": 454})
    lamps = [lamp(one, one, BRIGHTNESS, {**WHITE, **bounds}) for one, bounds in zip((LAMP, PLUG), whites, strict=True)]
    heard(convention, *lamps)
    (part,) = device_in(groups(convention, group(LAMP, PLUG))).parts
    assert next(one.bounds for one in part.part.capabilities if one.name == "color_temperature") == (2198.0, 4000.0)


def test_a_group_of_gangs_names_and_asks_each_gang() -> None:
    convention = bridge()
    exposes = [{**SWITCH, "endpoint": one, "features": [{**STATE, "property": f"state_{one}"}]} for one in SIDES]
    endpoints = {"1": {"name": "left"}, "2": {"name": "right"}}
    heard(convention, entry(PLUG, "wall", definition={"exposes": exposes}, endpoints=endpoints))
    both = ({"ieee_address": PLUG, "endpoint": one} for one in (1, 2))
    (part,) = device_in(groups(convention, group(*both))).parts
    assert part.part.members == ("eui64:00158d0001abcde0#switch_left", "eui64:00158d0001abcde0#switch_right")
    assert isinstance(part.codec, AsksMembers)
    sent = part.codec.write("on_off", value=False)
    assert [one.topic for one in part.codec.questions(sent)] == [
        "zigbee2mqtt/wall/left/get",
        "zigbee2mqtt/wall/right/get",
    ]


def test_a_gang_with_a_name_that_its_exposes_do_not_have_is_the_device() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling", endpoints={"1": {"name": "default"}}))
    assert device_in(groups(convention, group(LAMP))).parts[0].part.members == ("eui64:00158d0001abcdef",)


LOCK = {"type": "lock", "features": [{**STATE, "value_on": "LOCK", "value_off": "UNLOCK"}]}


@pytest.mark.parametrize(
    "other",
    [
        entry(PLUG, "door", definition={"exposes": [LOCK]}),
        {**entry(PLUG, "old"), "definition": None},
        COORDINATOR := {"ieee_address": PLUG, "type": "Coordinator", "friendly_name": "Coordinator"},
    ],
)
def test_a_group_with_a_lock_an_unknown_device_or_nothing_in_common_is_not_described(other: dict[str, Any]) -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"), other)
    assert groups(convention, group(LAMP, PLUG)) == []
    assert groups(convention, group(), group(7, "odd", number=5), {"id": 6, "members": 1}) == []


@pytest.mark.parametrize("name", [None, 7, "", "bridge/x", "lamps/set", "a#", "x" * 600])
def test_a_group_whose_name_is_no_topic_is_left_out(name: object) -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"))
    assert groups(convention, {**group(LAMP), "friendly_name": name}) == []


def test_a_group_that_is_gone_is_withdrawn_and_one_that_loses_a_member_is_described_anew() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"), lamp(PLUG, "shelf"))
    groups(convention, group(LAMP, PLUG), group(LAMP, number=5))
    events = groups(convention, group(PLUG))
    assert [one.key for one in events if isinstance(one, DeviceWithdrawn)] == ["group/5"]
    assert [one.parts[0].part.members for one in events if isinstance(one, DeviceAnnounced)] == [
        ("eui64:00158d0001abcde0",)
    ]


def test_a_group_that_was_listed_before_its_members_is_described_with_them() -> None:
    convention = bridge("attic")
    assert groups(convention, group(LAMP), base="attic") == []
    events = heard(convention, lamp(LAMP, "ceiling"), base="attic")
    assert [one.key for one in events if isinstance(one, DeviceAnnounced)] == [f"attic/{LAMP}", "attic/group/4"]


def test_a_group_has_none_of_the_settings_of_its_lamps() -> None:
    convention = bridge()
    setting = {"type": "composite", "name": "level_config", "property": "level_config", "access": 7, "features": []}
    heard(convention, lamp(LAMP, "ceiling", BRIGHTNESS, setting))
    assert [one.part.id for one in device_in(groups(convention, group(LAMP))).parts] == ["light"]


@pytest.mark.parametrize("number", [-1, 0x10000, 10**300, True, None, "4", 4.0])
def test_a_number_that_no_group_has_is_left_out(number: object) -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"))
    assert groups(convention, {**group(LAMP), "id": number}) == []


def test_the_gangs_of_a_group_that_was_listed_before_its_devices_are_named_again() -> None:
    convention = bridge()
    exposes = [{**SWITCH, "endpoint": one, "features": [{**STATE, "property": f"state_{one}"}]} for one in SIDES]
    endpoints = {"1": {"name": "left"}, "2": {"name": "right"}}
    groups(convention, group(PLUG))
    events = heard(convention, entry(PLUG, "wall", definition={"exposes": exposes}, endpoints=endpoints))
    (listed,) = (one for one in events if isinstance(one, GroupsListed))
    assert list(listed.members.values()) == [("eui64:00158d0001abcde0#switch_left",)]


def test_a_group_of_a_device_that_is_unknown_for_a_while_is_not_gone_for_good() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"))
    groups(convention, group(LAMP))
    events = heard(convention)
    assert [(one.key, one.is_final) for one in events if isinstance(one, DeviceWithdrawn)] == [
        (LAMP, True),
        ("group/4", False),
    ]


def test_the_scenes_of_a_group_are_its_parts() -> None:
    convention = bridge()
    heard(convention, lamp(LAMP, "ceiling"), lamp(PLUG, "shelf"))
    device = device_in(groups(convention, group(LAMP, PLUG, scenes=[{"id": 3, "name": "Film"}])))
    assert [(one.part.id, one.part.service_type, one.part.name) for one in device.parts] == [
        ("light", "light", ""),
        ("scene_3", "x_scene", "Film"),
    ]
