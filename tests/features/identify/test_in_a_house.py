"""A whole house identifies the lamp that its light sensor sees; in virtual time."""

import pytest

from homebot.features.identify import IDENTIFY_DEVICE
from homebot.features.identify.messages import IdentifyDevice, IdentifyDeviceGoal, IdentifyDeviceResult
from homebot.graph import Node
from homebot.graph.actions import ActionClient
from homebot.house.description import parse_world
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

LAMP = {"kind": "lamp"}
TABLES = {
    "house": {"dialect": "homeassistant"},
    "rooms": {"hall": {}, "attic": {}},
    "devices": {
        "hall_lamp": LAMP | {"room": "hall"},
        "hall_lux": {"kind": "lux", "room": "hall"},
        **{name: LAMP | {"room": "attic"} for name in ("attic_lamp", "spot", "shelf")},
    },
}


async def identified(house: VirtualHouse, candidates: str = "light") -> IdentifyDeviceResult:
    """Identify a lamp in the evening: by day the sensor reports no change as small as that of a lamp."""
    await house.run_for("1m")
    async with Node(house.runtime.graph, "rosie") as node:
        client = ActionClient(node, IdentifyDevice, IDENTIFY_DEVICE.name)
        goal = IdentifyDeviceGoal(candidates=candidates, topic="hall_lux", seconds=90.0, issuer="/rosie")
        sent = await client.send_goal(goal)
        _, result = await sent.result()
    return result


def are_on(house: VirtualHouse) -> dict[str, bool]:
    lamps = ("hall_lamp", "attic_lamp", "spot", "shelf")
    return {name: getattr(house.world.devices[name].device, "is_on", False) for name in lamps}


async def test_the_lamp_that_the_sensor_sees_is_found_and_all_are_as_before() -> None:
    async with virtual_house_of(world=parse_world(TABLES, "test"), start="2026-01-01 20:00") as house:
        before = are_on(house)
        found = await identified(house)
        assert (found.success, found.name) == (True, "hall_lamp"), found.message
        assert are_on(house) == before


async def test_a_lamp_that_the_sensor_does_not_see_is_not_in_view_or_the_sensor_is_too_slow() -> None:
    """It reports changes alone: nobody can know why it says nothing."""
    async with virtual_house_of(world=parse_world(TABLES, "test"), start="2026-01-01 20:00") as house:
        found = await identified(house, "attic_lamp")
        problem = "hall_lux reported nothing while all changed: it sees none of them, or is too slow"
        assert (found.success, found.message) == (False, problem)
