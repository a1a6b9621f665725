"""Lamps that publish and take plain text, as in the thesis, in a simulated house; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.graph import Node
from homebot.house.description import parse_world
from homebot.support.toml_file import parse_toml
from homebot.testing import virtual_house_of
from homebot.testing.virtual_house import VirtualHouse

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

GAP = 40.0
LUX = 'devices.lux = { kind = "lux", room = "hall", dialect = "thesis" }'


@asynccontextmanager
async def house(
    faults: str = "", more: str = "", heartbeat: float = 300.0
) -> AsyncIterator[tuple[VirtualHouse, Light]]:
    """Open a house with one lamp, and give both."""
    lamp = f'devices.lamp = {{ kind = "lamp", room = "hall", dialect = "thesis", faults = {{ {faults} }} }}'
    world = parse_world(parse_toml(f"rooms.hall = {{}}\n{lamp}\n{more}", "test"), "test")
    config = {"control": {"witnesses": {"light": "lux"}}}
    async with (
        virtual_house_of(world=world, heartbeat=heartbeat, config=config) as opened,
        Node(opened.runtime.graph, "app") as node,
    ):
        await anyio.sleep(GAP)
        (light,) = await Devices(node).find(Light)
        yield opened, light


async def test_a_stuck_lamp_answers_with_what_it_said_before() -> None:
    async with house("stuck = {}") as (_, lamp):
        for _ in range(2):
            assert (await lamp.turn_on()).text == "contradicted: on_off is off"
            assert isinstance(await lamp.turn_off(), Confirmed)


async def test_a_lamp_that_missed_a_command_and_is_off_anyway_says_so() -> None:
    async with house("unplugged = { since = 100, until = 160 }") as (_, lamp):
        assert isinstance(await lamp.turn_on(), Confirmed)
        assert isinstance(await lamp.turn_off(), Confirmed)
        await anyio.sleep(70)
        assert not (await lamp.turn_on()).succeeded
        await anyio.sleep(60)
        assert isinstance(await lamp.turn_off(), Confirmed)


async def test_a_lamp_that_is_dimmed_by_hand_is_never_contradicted() -> None:
    """Of a lamp that says only "on" after that it is not known how bright it is."""
    async with house(more=LUX, heartbeat=2.0) as (home, lamp):
        for brightness in ("0.6", "0.3", "0.05"):
            await home.press("lamp", brightness)
            await anyio.sleep(GAP)
            for outcome in (await lamp.turn_off(), await lamp.turn_on(), await lamp.turn_off()):
                assert outcome.succeeded, outcome
            await anyio.sleep(GAP)


async def test_a_light_sensor_of_plain_text_witnesses_a_lamp() -> None:
    """It cannot contradict one: a text that is repeated is no new report."""
    async with house(more=LUX, heartbeat=2.0) as (_, lamp):
        for outcome in (await lamp.turn_on(), await lamp.turn_off()):
            assert isinstance(outcome, Confirmed)
            assert (outcome.evidence, outcome.witness) == (Evidence.WITNESSED, "lux")
