"""Entities at a gateway: what a description that comes again makes of what was said before."""

import json
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Any

import pytest

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.conventions.homeassistant:HomeAssistantDiscovery"
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


BRIDGE = ("homebot.conventions.homeassistant:HomeAssistantDiscovery", "homebot.conventions.zigbee2mqtt:Zigbee2Mqtt")
INFO = "zigbee2mqtt/bridge/info"


@pytest.mark.parametrize("devices", [1, 2_000])
async def test_the_info_of_a_large_bridge_tells_its_entities_their_state(make_house: MakeHouse, devices: int) -> None:
    """It is as long as an announcement."""
    config = {"unique_id": "v", "state_topic": INFO, "value_template": "{{ value_json.version }}"}
    known = {f"0x{number:016x}": {"friendly_name": "x" * 150, "retain": False} for number in range(devices)}
    info = json.dumps({"version": "2.14.1", "config": {"devices": known}})
    assert (len(info) > 256 * 1024) == (devices > 1)
    async with make_house(conventions=BRIDGE) as house:
        await house.say("homeassistant/sensor/v/config", json.dumps(config))
        await house.say(INFO, info)
        assert [told for _, told, _ in house.told()] == [{"v.value": "2.14.1"}]
        assert house.gateway.counters.oversize == 0
