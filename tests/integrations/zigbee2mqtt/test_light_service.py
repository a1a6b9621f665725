"""The light service with a switch of two gangs, through the real gateway and directory at a broker."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest
from tests.patience import PATIENCE
from tests.thesis_light_service import THESIS_LIGHT_SERVICE

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection

GANGS = [
    {
        "type": "light",
        "endpoint": gang,
        "features": [
            {
                "type": "binary",
                "name": "state",
                "property": f"state_{gang}",
                "endpoint": gang,
                "access": 7,
                "value_on": "ON",
                "value_off": "OFF",
            }
        ],
    }
    for gang in ("left", "right")
]
SWITCH = {
    "ieee_address": "0x00158d0001abcdef",
    "friendly_name": "wall",
    "type": "Router",
    "supported": True,
    "interview_completed": True,
    "definition": {"model": "m", "vendor": "v", "description": "d", "exposes": GANGS},
}


class Player:
    """Plays the devices, and hears what they are told."""

    def __init__(self, link: MqttConnection) -> None:
        self._link = link

    async def say(self, *messages: tuple[str, object]) -> None:
        """The broker keeps them; what is no text is spelled in JSON."""
        for topic, payload in messages:
            text = payload if isinstance(payload, str) else json.dumps(payload)
            await self._link.publish(topic, text.encode(), qos=1, retain=True)

    async def told(self) -> list[tuple[str, str]]:
        """What came next, as topic and payload."""
        with anyio.fail_after(PATIENCE):
            messages = await self._link.receive()
        self._link.ack(messages)
        return [(one.topic, one.payload.decode()) for one in messages]


@asynccontextmanager
async def player(homebot: Any) -> AsyncIterator[Player]:
    async with homebot.client("device") as link:
        await link.subscribe(MqttSubscription("+/+/set"))
        await link.wait_connected()
        yield Player(link)


@pytest.mark.homebot("light_service")
async def test_all_gangs_of_a_switch_are_turned_off(homebot: Any) -> None:
    async with player(homebot) as devices:
        await devices.say(
            ("zigbee2mqtt/bridge/devices", [SWITCH]),
            ("zigbee2mqtt/wall", {"state_left": "ON", "state_right": "ON"}),
        )
        expected = {("zigbee2mqtt/wall/set", '{"state_left":"OFF"}'), ("zigbee2mqtt/wall/set", '{"state_right":"OFF"}')}
        found: set[tuple[str, str]] = set()
        while not expected <= found:
            found.update(await devices.told())


@pytest.mark.homebot(THESIS_LIGHT_SERVICE)
async def test_the_gangs_that_a_text_does_not_reach_are_named(homebot: Any) -> None:
    async with player(homebot) as devices:
        await devices.say(
            ("zigbee2mqtt/bridge/devices", [SWITCH]),
            ("zigbee2mqtt/wall", {"state_left": "ON", "state_right": "ON"}),
        )
        assert await devices.told() == [("zigbee2mqtt/wall/set", '{"state_left":"OFF"}')]
    assert "turned it off, but not right" in str(homebot.log)
