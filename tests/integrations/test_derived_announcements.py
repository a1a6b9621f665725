"""A device in the list of its bridge needs none of the announcements that the bridge makes for Home Assistant."""

import json

import pytest
from tests.gateways.mqtt.simple_house import House, simple_house

pytestmark = pytest.mark.virtual_time

CONVENTIONS = (
    "homebot.integrations.zigbee2mqtt.formats:Zigbee2Mqtt",
    "homebot.integrations.homeassistant.formats:HomeAssistantDiscovery",
)
ADDRESS = "0x00158d0001abcdef"
STATE = {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"}
ENTRY = {
    "ieee_address": ADDRESS,
    "friendly_name": "plug",
    "definition": {"vendor": "IKEA", "model": "E1603", "exposes": [{"type": "switch", "features": [STATE]}]},
}
LISTED = f"zigbee2mqtt:{ADDRESS}"
CONFIG = f"homeassistant/sensor/{ADDRESS}/linkquality/config"
DERIVED = f"homeassistant:sensor/{ADDRESS}/linkquality"


async def list_devices(house: House, *entries: object) -> None:
    await house.say("zigbee2mqtt/bridge/devices", json.dumps(entries), retain=True)


async def announce(
    house: House, origin: str = "Zigbee2MQTT", device: str = ADDRESS, state_topic: str = "zigbee2mqtt/plug"
) -> None:
    config = {
        "unique_id": "linkquality",
        "state_topic": state_topic,
        "value_template": "{{ value_json.linkquality }}",
        "device": {"identifiers": [f"zigbee2mqtt_{device}"]},
        "origin": {"name": origin},
    }
    await house.say(CONFIG, json.dumps(config), retain=True)


def kinds(house: House) -> list[tuple[str, str]]:
    return [(one.key, one.kind) for one in house.sighted()]


async def test_what_a_bridge_announces_of_a_listed_device_is_not_registered() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house)
        assert kinds(house) == [(LISTED, "appeared")]
        assert house.gateway.counters.announcements_derived == 1


async def test_what_a_bridge_announced_before_its_list_came_is_removed_with_the_list() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await announce(house)
        await list_devices(house, ENTRY)
        assert kinds(house) == [(DERIVED, "appeared"), (LISTED, "appeared"), (DERIVED, "removed")]


async def test_what_another_program_announces_of_a_listed_device_is_registered() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house, origin="Node-RED")
        assert [one.key for one in house.sighted()] == [LISTED, DERIVED]


async def test_what_a_bridge_announces_of_a_group_is_registered() -> None:
    """The list has no groups."""
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house, device="1221051039810110150109113116116_1")
        assert [one.key for one in house.sighted()] == [LISTED, DERIVED]


@pytest.mark.parametrize("is_listed_first", [True, False])
async def test_a_group_has_the_members_that_its_bridge_lists(is_listed_first: bool) -> None:  # noqa: FBT001
    group = {"id": 1, "friendly_name": "group", "members": [{"ieee_address": ADDRESS, "endpoint": 1}]}
    async with simple_house(conventions=CONVENTIONS) as house:
        if is_listed_first:
            await house.say("zigbee2mqtt/bridge/groups", json.dumps([group]), retain=True)
        await announce(house, device="1221051039810110150109113116116_1")
        if not is_listed_first:
            await house.say("zigbee2mqtt/bridge/groups", json.dumps([group]), retain=True)
        assert house.sighted()[-1].parts[0].members == ("eui64:00158d0001abcdef",)
        await house.say("zigbee2mqtt/bridge/groups", json.dumps([{**group, "members": []}]), retain=True)
        assert house.sighted()[-1].parts[0].members == ()


async def test_a_device_that_left_the_list_is_again_what_its_bridge_announces() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await list_devices(house)
        await announce(house)
        assert kinds(house)[1:] == [(LISTED, "removed"), (DERIVED, "appeared")]


async def test_withdrawing_an_announcement_that_was_not_registered_changes_nothing() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house)
        assert len(kinds(house)) == 1
        await house.say(CONFIG, "", retain=True)
        assert not kinds(house)


async def test_an_announcement_that_names_its_program_at_last_is_removed() -> None:
    """As after an update of the bridge."""
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house, origin="")
        await announce(house)
        assert kinds(house)[1:] == [(DERIVED, "appeared"), (DERIVED, "removed")]


@pytest.mark.parametrize("is_listed_first", [True, False])
async def test_a_list_that_a_bridge_left_behind_hides_nothing(is_listed_first: bool) -> None:  # noqa: FBT001
    """A bridge that gets another base topic leaves its list on the broker."""
    async with simple_house(conventions=CONVENTIONS) as house:
        if is_listed_first:
            await list_devices(house, ENTRY)
        await announce(house, state_topic="z2m/plug")
        if not is_listed_first:
            await list_devices(house, ENTRY)
        assert sorted(kinds(house)) == [(DERIVED, "appeared"), (LISTED, "appeared")]
