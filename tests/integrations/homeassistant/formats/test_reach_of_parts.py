"""Availability of parts, from Home Assistant's announcement of a whole device to a handle."""

import anyio
import pytest
from tests.gateways.mqtt.known_house import KnownHouse, known_house

from homebot.devices import Device
from homebot.devices.handles import Light, Switch

pytestmark = pytest.mark.virtual_time

DEVICE = {"identifiers": ["panel-4711"], "name": "Panel"}
LAMP = {"platform": "light", "unique_id": "l", "command_topic": "p/l/set", "state_topic": "p/l"}
RELAY = {"platform": "switch", "unique_id": "s", "command_topic": "p/s/set", "state_topic": "p/s"}


async def announce(house: KnownHouse, *, lamp: dict[str, str], relay: dict[str, str], **common: object) -> None:
    components = {"l": {**LAMP, **lamp}, "s": {**RELAY, **relay}}
    origin = {"name": "test"}
    message = {"device": DEVICE, "origin": origin, "components": components, **common}
    await house.say("homeassistant/device/panel/config", message, retain=True)
    await anyio.sleep(1)


async def panel_of(house: KnownHouse) -> Device:
    (found,) = await house.devices.find()
    return found


async def test_each_component_tells_for_itself() -> None:
    async with known_house() as house:
        await announce(house, lamp={"availability_topic": "p/l/up"}, relay={"availability_topic": "p/s/up"})
        await house.say("p/l/up", "offline")
        await house.say("p/s/up", "online")
        panel = await panel_of(house)
        assert (panel.reachable.state, panel.offline_parts) == ("yes", ("l",))
        assert [one.reachable for one in await house.devices.find(Light)] == [False]
        assert [one.reachable for one in await house.devices.find(Switch)] == [True]
        assert not await house.devices.find(Light, reachable=True)
        assert len(await house.devices.find(Light, reachable=False)) == 1
        await house.say("p/l/up", "online")
        assert (await panel_of(house)).offline_parts == ()


async def test_one_that_is_offline_and_another_that_says_nothing_but_speaks() -> None:
    """As seen with a panel of which one entity alone has an availability topic."""
    async with known_house() as house:
        await announce(house, lamp={"availability_topic": "p/l/up"}, relay={})
        await house.say("p/l/up", "offline")
        await house.say("p/s", "ON")
        panel = await panel_of(house)
        assert (panel.reachable.state, panel.offline_parts, panel.freshness) == ("unknown", ("l",), "fresh")
        assert [one.reachable for one in await house.devices.find(Switch)] == [None]


async def test_shared_availability_is_of_the_device_and_that_of_a_part_comes_first() -> None:
    async with known_house() as house:
        await announce(house, lamp={}, relay={"availability_topic": "p/s/up"}, availability_topic="p/up")
        await house.say("p/up", "online")
        await house.say("p/s/up", "offline")
        assert ((await panel_of(house)).reachable.state, (await panel_of(house)).offline_parts) == ("yes", ("s",))
        await house.say("p/up", "offline")
        assert ((await panel_of(house)).reachable.state, (await panel_of(house)).offline_parts) == ("no", ("l", "s"))


async def test_an_announcement_without_availability_ends_what_was_said_before() -> None:
    async with known_house() as house:
        await announce(house, lamp={}, relay={}, availability_topic="p/up")
        await house.say("p/up", "offline")
        assert (await panel_of(house)).reachable.state == "no"
        await announce(house, lamp={}, relay={})
        assert ((await panel_of(house)).reachable.state, (await panel_of(house)).offline_parts) == ("unknown", ())
