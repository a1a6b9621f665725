"""Numbers that the owner drops or sets, in single values, in summaries, and in what a meter counted."""

import anyio
import pytest
from tests.features.history.conftest import MIDNIGHT, KeptHouse, MakeHouse

pytestmark = pytest.mark.virtual_time

HOUR = 3600.0
DAY = 24 * HOUR


async def spoiled(house: KeptHouse, hours: int) -> None:
    """Let a thermometer say 20 for some hours, and 85 for a minute in the second."""
    await house.report("thermometer", temperature=20.0)
    await anyio.sleep(HOUR)
    await house.report("thermometer", temperature=85.0)
    await anyio.sleep(60)
    await house.report("thermometer", temperature=20.0)
    await anyio.sleep((hours - 1) * HOUR)


@pytest.mark.parametrize(("hours", "since"), [(1, 3 * HOUR), (6, 7 * HOUR), (72, 20 * DAY), (72, 365 * DAY)])
async def test_what_is_dropped_is_in_no_value_and_in_no_summary(kept: MakeHouse, hours: int, since: float) -> None:
    async with kept() as house:
        await spoiled(house, hours)
        assert max((one := await house.read("thermometer", since=since, points=5000)).highs or one.values) == 85.0
        answer = await house.correct("thermometer", "temperature", HOUR - 300, HOUR + 600)
        assert (answer.success, answer.count > 0) == (True, True), answer.message
        series = await house.read("thermometer", since=since, points=5000)
    assert {*series.values, *series.lows, *series.highs} == {20.0}


async def test_a_value_takes_the_place_of_those_between(kept: MakeHouse) -> None:
    async with kept() as house:
        await spoiled(house, 1)
        assert (await house.correct("thermometer", "temperature", HOUR - 10, HOUR + 50, 20.5)).success
        series = await house.read("thermometer")
    assert sorted({*series.values}) == [20.0, 20.5]


async def test_a_meter_counts_on_without_what_was_dropped(kept: MakeHouse) -> None:
    async with kept() as house:
        for total in (100.0, 101.0, 900.0):
            await house.report("meter", energy=total)
            await anyio.sleep(100)
        assert (await house.correct("meter", "energy", 150, 400)).success
        await house.report("meter", energy=102.0)
        await anyio.sleep(10)
        assert [day.used for day in await house.energy()] == [2.0]
    async with kept(MIDNIGHT + 3 * HOUR) as house:
        await house.report("meter", energy=103.0)
        assert [day.used for day in await house.energy()] == [3.0]


@pytest.mark.parametrize(
    ("device", "capability", "end", "problem"),
    [
        ("thermometre", "temperature", HOUR, "there is no history of 'thermometre'; `homebot devices` lists the ids"),
        ("thermometer", "temprature", HOUR, "thermometer has no history of 'temprature'; did you mean temperature?"),
        ("thermometer", "temperature", 0.0, "the start must be before the end"),
        ("thermometer", "temperature", -DAY, "the start must be before the end"),
    ],
)
async def test_what_cannot_be_corrected_is_said(
    kept: MakeHouse, device: str, capability: str, end: float, problem: str
) -> None:
    async with kept() as house:
        await spoiled(house, 1)
        answer = await house.correct(device, capability, 0.0, end)
        assert (answer.success, answer.message) == (False, problem)
        nothing = await house.correct("thermometer", "temperature", -DAY, -HOUR)
        assert nothing.message.startswith("there are no numbers in that time, or only summaries of a longer one")
