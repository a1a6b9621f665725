"""Real products on one broker: all the way through gateway and directory."""

import json
from typing import Any, TypeAlias

import anyio
import pytest
from tests.gateways.mqtt.known_house import known_house
from tests.integrations.real_devices import rows_of

from homebot.conventions.description import DeviceAnnounced
from homebot.devices import Device
from homebot.plugins import load_plugin

Row: TypeAlias = dict[str, Any]

CONVENTIONS = {
    "homeassistant": "homebot.integrations.homeassistant.formats:HomeAssistantDiscovery",
    "zigbee2mqtt": "homebot.integrations.zigbee2mqtt.formats:Zigbee2Mqtt",
    "tasmota": "homebot.integrations.tasmota.formats:TasmotaDiscovery",
    "shelly": "homebot.integrations.shelly.formats:Shelly",
    "homie": "homebot.integrations.homie.formats:Homie",
}
BRIDGE = "zigbee2mqtt/bridge/devices"


def rows(convention: str, each: int) -> list[Row]:
    return rows_of(convention)[::each]


def announced(products: list[Row]) -> list[tuple[str, str]]:
    """Their announcements; a bridge lists all of its devices in one."""
    messages = [(topic, payload) for row in products for topic, payload in row["messages"]]
    listed = [one for topic, payload in messages if topic == BRIDGE for one in json.loads(payload)]
    others = [message for message in messages if message[0] != BRIDGE]
    return [*others, (BRIDGE, json.dumps(listed))] if listed else others


@pytest.mark.virtual_time
@pytest.mark.parametrize("convention", CONVENTIONS)
async def test_a_house_of_real_products_is_known(convention: str) -> None:
    """Each is there, and what it says comes to be known; nobody is judged to break rules."""
    products = rows(convention, 2)
    async with known_house(conventions=(CONVENTIONS[convention],)) as house:
        wire, directory = house.wire, house.directory
        for topic, payload in announced(products):
            await wire.publish(topic, payload.encode(), qos=1, retain=not topic.startswith("homebot/"))
        await anyio.sleep(300)  # questions are asked one after the other
        known = directory.index.devices()
        unsaid = {device.id for device in known if not device.states}
        for row in products:
            for topic, payload, _ in row["says"]:
                await wire.publish(topic, payload.encode(), qos=1)
        await anyio.sleep(30)
        told = directory.index.devices()
    assert {device.id for device in known} == {device.id for device in told}
    missing = [row["model"] for row in products if not is_known(row, told, identity(convention, row))]
    assert not missing
    assert sum(device.id in unsaid and bool(device.states) for device in told) > 0.5 * len(unsaid)


def identity(convention: str, row: Row) -> set[str]:
    """Who the product says it is."""
    kind = load_plugin("homebot.mqtt_conventions", CONVENTIONS[convention])
    reader = kind(kind.Settings())
    heard = [
        one for topic, payload in row["messages"] for one in reader.read_message(topic, payload.encode(), retained=True)
    ]
    return {identifier for one in heard if isinstance(one, DeviceAnnounced) for identifier in one.identifiers}


def is_known(row: Row, told: tuple[Device, ...], identifiers: set[str]) -> bool:
    """Whether one device alone is the product, and offers all that it does; who describes nothing has no identity."""
    found = [device for device in told if identifiers & set(device.identifiers)]
    offered = {part.part.service_type for device in found for part in device.parts}
    return not identifiers or (len(found) == 1 and set(row["types"]) <= offered)
