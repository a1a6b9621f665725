"""Entities at a gateway: what a description that comes again makes of what was said before."""

import json
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Any

import pytest

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.gateways.mqtt.homeassistant:HomeAssistantDiscovery"
THERMOSTAT = {
    "unique_id": "u",
    "modes": ["off", "heat", "heat_cool"],
    "mode_command_topic": "b/mode/set",
    "mode_state_topic": "b/mode",
    "temperature_command_topic": "b/t/set",
    "temperature_low_command_topic": "b/low/set",
    "temperature_high_command_topic": "b/high/set",
}

MakeHouse = Callable[..., AbstractAsyncContextManager[Any]]


@pytest.mark.parametrize("again", [{}, {"name": "Hall"}])
async def test_a_thermostat_that_is_announced_again_is_still_in_its_mode(
    make_house: MakeHouse, again: dict[str, str]
) -> None:
    """Also where nothing of it changed: its command goes where its mode says."""
    async with make_house(conventions=(CONVENTION,)) as house:
        await house.listen("b/+/set")
        await house.say("homeassistant/climate/x/config", json.dumps(THERMOSTAT), retain=True)
        await house.say("b/mode", "heat_cool")
        await house.say("homeassistant/climate/x/config", json.dumps({**THERMOSTAT, **again}), retain=True)
        answer = await house.command("homeassistant:climate/x", "u", "heating_setpoint", 21.0)
        assert answer.success
        assert [(one.topic, one.payload) for one in await house.heard()] == [("b/low/set", b"21.0")]
