"""Routines that dim a lamp while a button is held; in virtual time."""

import json

import pytest
from tests.apps.houses import flat, lamp

from homebot.house import World
from homebot.house.devices import SimulatedLamp
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

CONFIG = {
    "home": {"zone": "UTC"},
    "routines": [
        {"name": "Dim", "when": ["hall button press hold"], "do": ["hall lamp dim while hall button hold"]},
        {"name": "Down", "when": ["hall button press down"], "do": ["hall lamp darken while hall button down"]},
    ],
}


def home() -> World:
    return flat(hall_lamp=lamp("hall"))


def level(world: World) -> float:
    """The brightness in percent; 0 while it is off."""
    found = world.devices["hall_lamp"].device
    assert isinstance(found, SimulatedLamp)
    return round(100 * found.brightness) if found.is_on else 0.0


async def held(house: VirtualHouse, event: str, *, seconds: float = 0.0, end: str = "release") -> None:
    """Press the hall button, and release it after *seconds*; 0 for never."""
    device = {"identifiers": ["b1"], "name": "Hall button"}
    for one in ("hold", "down", "release", "single"):
        found = {"automation_type": "trigger", "type": "action", "subtype": one, "topic": "b1", "payload": one}
        topic = f"homeassistant/device_automation/b1/{one}/config"
        await house.says(topic, json.dumps({**found, "device": device}))
    await house.run_for(1)
    await house.says("b1", event)
    if seconds:
        await house.run_for(seconds)
        await house.says("b1", end)


@pytest.mark.parametrize("end", ["release", "single"])
async def test_the_lamp_changes_until_the_button_reports_anything_else(end: str) -> None:
    world = home()
    async with virtual_house_of(world=world, config=CONFIG) as house:
        await held(house, "hold", seconds=1.8, end=end)
        await house.run_for(5)
        assert level(world) == 40.0


async def test_a_lost_release_ends_after_ten_seconds_or_at_the_end() -> None:
    world = home()
    async with virtual_house_of(world=world, config=CONFIG) as house:
        await held(house, "hold")
        await house.run_for(20)
        assert level(world) == 100.0


async def test_it_never_turns_the_lamp_off_and_dims_back_from_above() -> None:
    world = home()
    async with virtual_house_of(world=world, config=CONFIG) as house:
        await house.press("hall_lamp", "0.3")
        await held(house, "down")
        await house.run_for(20)
        assert level(world) == 1.0
