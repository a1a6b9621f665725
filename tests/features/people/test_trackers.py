"""Trackers that Home Assistant's discovery announces: what they told holds while they sleep; in virtual time."""

import json

import pytest

from homebot.devices import Devices
from homebot.graph import Node
from homebot.testing import VirtualHouse

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

CONFIG = {"people": {"Anna": {"trackers": ["Anna's phone"]}}}
TRACKER = {"name": None, "unique_id": "phone", "state_topic": "anna/place", "source_type": "gps"}


async def is_home(house: VirtualHouse) -> object:
    async with Node(house.runtime.graph, "asking") as node:
        (person,) = await Devices(node).find("person")
        return person.states[0].value.plain()


@pytest.mark.house(config=CONFIG)
@pytest.mark.parametrize("has_availability", [True, False])
async def test_a_tracker_keeps_what_it_told_for_a_day_or_while_it_is_available(
    house: VirtualHouse, *, has_availability: bool
) -> None:
    """Nobody is home is known after eight hours, as the guide's routines need it."""
    device = {"identifiers": ["phone"], "name": "Anna's phone"}
    more = {"availability_topic": "anna/status"} if has_availability else {}
    await house.says("homeassistant/device_tracker/phone/config", json.dumps(TRACKER | {"device": device} | more))
    await house.run_for("5s")
    if has_availability:
        await house.says("anna/status", "online")
    for place, told in (("home", True), ("not_home", False)):
        await house.says("anna/place", place)
        await house.run_for("8h")
        assert await is_home(house) is told
    await house.run_for("20h")
    assert await is_home(house) is (False if has_availability else None)
    if has_availability:
        await house.says("anna/status", "offline")
        await house.run_for("1m")
        assert await is_home(house) is None
