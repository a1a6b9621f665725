"""A lamp that is announced twice, as after a rename: one device, and one command each time."""

from typing import Any

import anyio
import pytest
from tests.gateways.mqtt.known_house import known_house

from homebot.devices.handles import Light
from homebot.mqtt.client import MqttSubscription

pytestmark = pytest.mark.virtual_time


def lamp(unique_id: str, *identifiers: str) -> dict[str, Any]:
    """A lamp of Home Assistant discovery, whose topics are the same whatever it is called."""
    device = {"device": {"identifiers": identifiers, "name": unique_id}} if identifiers else {}
    return {"unique_id": unique_id, "name": unique_id, "command_topic": "lamp4/set", "state_topic": "lamp4"} | device


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ({"old_lamp": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m1234")}),
        ({"old_lamp": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m5678")}),
        ({"old_lamp": lamp("old_lamp")}, {"new_lamp": lamp("new_lamp")}),
        ({"old_lamp": lamp("kept", "m1234")}, {"new_lamp": lamp("kept", "m1234")}),
        ({"lamp4": lamp("old_lamp", "m1234")}, {"new_lamp": lamp("new_lamp", "m5678")}),
        ({"old_lamp_4": lamp("old_lamp", "m1234")}, {"old_lamp_5": lamp("new_lamp", "m5678")}),
    ],
    ids=["unique id", "device", "no device", "place", "named by its topic", "names in common"],
)
async def test_a_lamp_that_is_left_over_from_a_rename_is_neither_refused_nor_commanded_twice(
    before: dict[str, Any], after: dict[str, Any]
) -> None:
    async with known_house(act=True) as house:
        await house.wire.subscribe(MqttSubscription("lamp4/set"))
        for name, config in (before | after).items():
            await house.say(f"homeassistant/light/{name}/config", config, retain=True)
        await anyio.sleep(1)
        (light,) = await house.devices.find(Light)
        assert [len(part.routes) for part in light.device.parts] == [2]
        for _ in range(2):
            assert (await light.turn_on()).succeeded
            assert (await light.turn_off()).succeeded
        assert [one.payload for one in await house.wire.receive()] == [b"ON", b"OFF"] * 2
