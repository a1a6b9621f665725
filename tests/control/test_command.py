"""The settings of a command are sent in an order in which devices take them; in virtual time."""

from itertools import permutations

import anyio
import pytest
from tests.control.conftest import Home

from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time


@pytest.mark.parametrize(
    ("heat", "cool", "order"),
    [
        (25.0, 28.0, ["thermostat_mode", "cooling_setpoint", "heating_setpoint", "thermostat_mode"]),
        (16.0, 19.0, ["thermostat_mode", "heating_setpoint", "cooling_setpoint", "thermostat_mode"]),
    ],
)
async def test_a_thermostat_is_set_after_its_mode_and_never_to_heat_to_more_than_it_cools_to(
    home: Home, heat: float, cool: float, order: list[str]
) -> None:
    """As a thermostat of ecobee or Lennox refuses that in the mode auto, which many leave when they get a setpoint."""
    values: dict[str, PlainValue] = {"thermostat_mode": "auto", "heating_setpoint": heat, "cooling_setpoint": cool}
    for names in permutations(values):
        home.put("hall", "thermostat", *values)
        now: dict[str, PlainValue] = {"thermostat_mode": "heat", "heating_setpoint": 20.0, "cooling_setpoint": 24.0}
        await home.gateway.devices.report("hall", now)
        await anyio.sleep(1.0)
        home.commands.clear()
        settings = tuple(Setting.of(one, values[one]) for one in names)
        await home.control.perform(CommandRequest(device="hall", settings=settings, issuer="client:anna"))
        assert [one.capability for one in home.commands] == order


@pytest.mark.parametrize("level", ["level", "fan_speed"])
async def test_what_has_a_level_is_turned_on_last(home: Home, level: str) -> None:
    home.put("it", "light" if level == "level" else "fan", "on_off", level)
    await home.gateway.devices.report("it", {"on_off": False, level: 100.0})
    await anyio.sleep(1.0)
    settings = (Setting.of("on_off", True), Setting.of(level, 30.0))
    await home.control.perform(CommandRequest(device="it", settings=settings, issuer="client:anna"))
    assert [one.capability for one in home.commands] == [level, "on_off"]
