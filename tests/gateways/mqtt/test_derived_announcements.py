"""A device in the list of its bridge needs none of the announcements that the bridge makes for Home Assistant."""

from __future__ import annotations

import json

import pytest
from tests.gateways.mqtt.simple_house import House, simple_house

pytestmark = pytest.mark.virtual_time

CONVENTIONS = (
    "homebot.conventions.zigbee2mqtt:Zigbee2Mqtt",
    "homebot.conventions.homeassistant:HomeAssistantDiscovery",
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


async def announce(house: House, topic: str = CONFIG, origin: str = "Zigbee2MQTT", device: str = ADDRESS) -> None:
    config = {
        "unique_id": topic,
        "state_topic": "zigbee2mqtt/plug",
        "value_template": "{{ value_json.linkquality }}",
        "device": {"identifiers": [f"zigbee2mqtt_{device}"]},
        "origin": {"name": origin},
    }
    await house.say(topic, json.dumps(config), retain=True)


async def test_what_a_bridge_announces_of_a_listed_device_is_not_registered() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house)
        assert [one.key for one in house.sighted()] == [LISTED]
        assert house.gateway.counters.announcements_derived == 1


async def test_what_a_bridge_announced_before_its_list_came_is_removed_with_the_list() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await announce(house)
        await list_devices(house, ENTRY)
        assert [(one.key, one.kind) for one in house.sighted()] == [
            (DERIVED, "appeared"),
            (LISTED, "appeared"),
            (DERIVED, "removed"),
        ]


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


async def test_a_device_that_left_the_list_is_again_what_its_bridge_announces() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await list_devices(house)
        await announce(house)
        assert [(one.key, one.kind) for one in house.sighted()][1:] == [(LISTED, "removed"), (DERIVED, "appeared")]


async def test_withdrawing_an_announcement_that_was_not_registered_changes_nothing() -> None:
    async with simple_house(conventions=CONVENTIONS) as house:
        await list_devices(house, ENTRY)
        await announce(house)
        await house.say(CONFIG, "", retain=True)
        assert [one.key for one in house.sighted()] == [LISTED]
