"""A simulated lamp that begins to lie beside a simulated light sensor; in virtual time."""

from __future__ import annotations

import anyio
import pytest
from tests.control.witnesses.rooms import toggle

from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.outcomes import Contradicted, Evidence
from homebot.graph import Node
from homebot.house.description import parse_world
from homebot.testing import virtual_house_of
from homebot.toml_file import parse_toml

pytestmark = pytest.mark.virtual_time

GAP = 40.0
HONEST = 14
HOUSE = """
rooms.hall = {}
devices.lamp = { kind = "lamp", room = "hall", dialect = "homeassistant", faults = { liar = { since = SINCE } } }
devices.lux = { kind = "lux", room = "hall", dialect = "DIALECT" }
"""


@pytest.mark.parametrize("dialect", ["homeassistant", "zigbee2mqtt"])
async def test_a_lamp_that_begins_to_lie_is_contradicted_each_time(dialect: str) -> None:
    """Also beside a sensor that does not say in which room it is."""
    text = HOUSE.replace("SINCE", str((HONEST + 0.5) * GAP)).replace("DIALECT", dialect)
    world = parse_world(parse_toml(text, "test"), "test")
    async with virtual_house_of(world=world, heartbeat=2.0) as house, Node(house.runtime.graph, "app") as node:
        await anyio.sleep(GAP)
        (lamp,) = await Devices(node).find(Light)
        grades = await toggle(lamp, HONEST, GAP)
        assert grades[-2:] == [("lux", Evidence.WITNESSED)] * 2
        assert [type(await lamp.turn_on()) for _ in range(4)] == [Contradicted] * 4
