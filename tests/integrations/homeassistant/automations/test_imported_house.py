"""Imported automations do in a house what they did in Home Assistant; in virtual time."""

import tomllib

import pytest
from tests.apps.houses import hall, is_on

from homebot.cli.yaml_loader import load_located
from homebot.clock import read_zone
from homebot.devices import Devices
from homebot.features.routines.text import read_routines
from homebot.graph import Node
from homebot.house import World
from homebot.integrations.homeassistant.automations import HomeAssistantAutomations
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

MOTION_LIGHT = """
- alias: Hall
  mode: restart
  trigger: {platform: state, entity_id: binary_sensor.hall_motion, to: 'on'}
  condition: {condition: state, entity_id: light.hall_lamp, state: 'off'}
  action:
    - {service: light.turn_on, entity_id: light.hall_lamp}
    - wait_for_trigger: {platform: state, entity_id: binary_sensor.hall_motion, to: 'off', for: '00:02:00'}
      timeout: {minutes: 30}
    - {service: light.turn_off, entity_id: light.hall_lamp}
"""
BY_IDS = """
- alias: Times
  trigger:
    - {platform: time, at: '08:00', id: begin}
    - {platform: time, at: '09:00', id: end}
  action:
    - choose:
        - conditions: [{condition: trigger, id: begin}]
          sequence: [{service: light.turn_on, entity_id: light.hall_lamp}]
        - conditions: [{condition: trigger, id: end}]
          sequence: [{service: light.turn_off, entity_id: light.hall_lamp}]
"""
MIDDLE = """
- alias: Door
  trigger: {platform: time, at: '08:00'}
  action:
    - delay: 60
    - {condition: state, entity_id: light.hall_lamp, state: 'off'}
    - choose: []
      default: [{service: light.turn_on, entity_id: light.hall_lamp}]
"""
read_zone("UTC")  # read from the disk before any loop runs


async def imported(world: World, text: str) -> dict[str, object]:
    """Return a configuration with the routines that *text* becomes in the house of *world*."""
    async with virtual_house_of(world=world) as house:
        await house.run_for("10s")
        async with Node(house.runtime.graph, "test") as node:
            devices = tuple(await Devices(node).find())
    found = HomeAssistantAutomations().read(
        load_located(text), "a.yaml", devices, lambda text, origin: read_routines(text, origin)[0]
    )
    assert not found.refused
    return {**tomllib.loads("\n".join(found.texts)), "home": {"zone": "UTC"}}


async def test_a_light_follows_motion_and_ends_two_minutes_after_it() -> None:
    config = await imported(hall(), MOTION_LIGHT)
    world = hall(("08:00", "hall"), ("08:05", "outside"))
    async with virtual_house_of(world=world, config=config) as house:
        await house.run_until("08:01")
        assert is_on(world, "hall_lamp")
        await house.run_until("08:30")
        assert not is_on(world, "hall_lamp")


async def test_triggers_with_ids_take_their_own_branch() -> None:
    config = await imported(hall(), BY_IDS)
    world = hall()
    async with virtual_house_of(world=world, config=config) as house:
        for at, expected in (("08:01", True), ("09:01", False)):
            await house.run_until(at)
            assert is_on(world, "hall_lamp") is expected


@pytest.mark.parametrize("was_on", [True, False])
async def test_a_condition_in_the_middle_is_asked_then(*, was_on: bool) -> None:
    config = await imported(hall(), MIDDLE.replace("'off'", "'on'" if was_on else "'off'"))
    world = hall()
    async with virtual_house_of(world=world, config=config) as house:
        await house.run_until("08:02")
        assert is_on(world, "hall_lamp") is not was_on
