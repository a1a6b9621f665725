"""Dimmers that round what they are told; in virtual time."""

import math
from collections.abc import Callable
from typing import TypeAlias

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, OpenHome, hold_request, report

from homebot.control.timeline.profile import DeviceProfile
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted, Outcome
from homebot.devices.part import Capability, Part
from homebot.gateways.announced.gateway_device import GatewayDevice

Rounding: TypeAlias = Callable[[float], float]


def nearest(step: float) -> Rounding:
    return lambda level: step * math.floor(level / step + 0.5)


def down(step: float) -> Rounding:
    return lambda level: step * math.floor(level / step)


def up(step: float) -> Rounding:
    return lambda level: step * math.ceil(level / step)


def dimmer(rounding: Rounding) -> Behaviour:
    """Take what the device makes of a level, to one of 255 values."""

    async def behaviour(home: Home, command: Command) -> None:
        value = command.value.plain()
        assert isinstance(value, float)
        await home.report(command.key, "level", round(rounding(value) * 2.55) / 2.55)

    return behaviour


async def dimmed(open_home: OpenHome, behaviour: Behaviour, levels: tuple[float, ...]) -> list[Outcome]:
    async with open_home() as home:
        lamp = await home.lamp("on_off", "level", behaviour=behaviour)
        outcomes: list[Outcome] = []
        for level in levels:
            outcomes.append(await lamp.set_level(level))
            await anyio.sleep(90)
        return outcomes


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    "rounding", [nearest(5.0), nearest(10.0), down(5.0), down(10.0), up(10.0), up(20.0), nearest(100 / 7)]
)
async def test_a_dimmer_that_rounds_is_contradicted_until_its_steps_are_known(
    open_home: OpenHome, rounding: Rounding
) -> None:
    levels = (62.0, 33.0, 47.0, 78.0, 17.0, 23.0, 92.0, 54.0, 68.0, 38.0, 72.0)
    outcomes = await dimmed(open_home, dimmer(rounding), levels)
    assert isinstance(outcomes[0], Contradicted)
    assert all(isinstance(one, Confirmed) for one in outcomes[7:]), outcomes


@pytest.mark.virtual_time
async def test_one_that_is_known_to_round_is_contradicted_at_another_step(home: Home) -> None:
    broken = False

    def rounding(level: float) -> float:
        return 20.0 if broken else 5.0 * math.floor(level / 5.0 + 0.5)

    lamp = await home.lamp("on_off", "level", behaviour=dimmer(rounding))
    for level in (62.0, 33.0, 47.0):
        assert isinstance(await lamp.set_level(level), Contradicted)
    assert isinstance(await lamp.set_level(88.0), Confirmed)
    broken = True
    outcome = await lamp.set_level(73.0)
    assert isinstance(outcome, Contradicted)
    assert outcome.saw == "level is 20"


def rounding(*answers: tuple[float, float]) -> float:
    profile = DeviceProfile()
    for wanted, seen in answers:
        profile.learn_answer("level", wanted, seen)
    return profile.rounding("level")


def test_a_rounding_takes_three_answers_with_two_values() -> None:
    assert rounding((62.0, 60.0), (33.0, 35.0)) == 0.0
    assert rounding((62.0, 60.0), (58.0, 60.0), (59.0, 60.0)) == 0.0
    assert rounding((62.0, 60.0), (33.0, 35.0), (47.0, 45.0)) == pytest.approx(3.5)


def test_an_error_of_more_than_a_quarter_is_no_rounding() -> None:
    """A hand at the dial, a lamp that got stuck, or one that goes its own way."""
    assert rounding((62.0, 60.0), (33.0, 35.0), (47.0, 45.0), (20.0, 71.0)) == 0.0


def test_nothing_is_kept_of_a_device_that_does_as_told() -> None:
    profile = DeviceProfile()
    profile.learn_answer("level", 62.0, 62.0)
    assert not profile.answers


def test_a_setpoint_is_not_rounded_by_degrees() -> None:
    profile = DeviceProfile()
    for wanted in (17.0, 19.0, 21.0):
        profile.learn_answer("heating_setpoint", wanted, wanted + 2.0)
    assert (profile.answers, profile.rounding("heating_setpoint")) == ({}, 0.0)


def dimmer_of_ten(home: Home) -> None:
    grid = Capability(name="level", settable=True, grid=(0.0, 10.0))
    part = Part(id="", service_type="light", capabilities=(Capability(name="on_off", settable=True), grid))
    home.gateway.devices.put(GatewayDevice("lamp", "Lamp", (part,)), "the test says so")


@pytest.mark.virtual_time
async def test_a_level_between_announced_steps_is_sent_as_the_nearest_and_that_is_said(home: Home) -> None:
    dimmer_of_ten(home)
    lamp = await home.handle(Light, "lamp")
    outcome = await lamp.set_level(44.0)
    assert isinstance(outcome, Confirmed)
    assert [one.value.plain() for one in home.commands] == [40.0]
    assert outcome.text.endswith("; level 40 % is what the device can do")
    again = await lamp.set_level(44.0)
    assert again.text == "it was so already; level 40 % is what the device can do"
    assert (await lamp.set_level(30.0)).warning == ""


@pytest.mark.virtual_time
async def test_a_device_that_misses_its_own_step_is_contradicted(home: Home) -> None:
    dimmer_of_ten(home)
    home.behaviours["lamp"] = report((0.1, 50.0))
    outcome = await (await home.handle(Light, "lamp")).set_level(44.0)
    assert isinstance(outcome, Contradicted)
    assert outcome.saw == "level is 50"


@pytest.mark.virtual_time
async def test_a_held_level_is_held_at_the_step_that_the_device_can_do(home: Home) -> None:
    dimmer_of_ten(home)
    await home.handle(Light, "lamp")
    await home.hold(hold_request("lamp", "level", 44.0))
    await anyio.sleep(5)
    assert [one.value.plain() for one in home.commands] == [40.0]
    (held,) = await home.leases()
    assert held.setting.value.plain() == 40.0
