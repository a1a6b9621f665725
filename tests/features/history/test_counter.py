"""What a counter counted: a reset is not a glitch, and jitter is no energy."""

import random

import anyio
import pytest
from tests.features.history.conftest import MIDNIGHT, MakeHouse

from homebot.features.history.buckets import FIVE_MINUTES, buckets_of
from homebot.features.history.counter import CounterTotal

MINUTE = 60_000


def counted(totals: tuple[float, ...], every: int = MINUTE) -> float:
    """The sum of what is recorded of *totals*, of which one comes each *every* milliseconds."""
    counter, times, values = CounterTotal(None), list[int](), list[float]()
    for number, total in enumerate(totals):
        for one in counter.record(total, number * every):
            times.append(number * every)
            values.append(one)
    buckets = buckets_of(times, values, FIVE_MINUTES, len(totals) * every, is_counter=True)
    return sum(one.rise for one in buckets.values())


@pytest.mark.parametrize(
    ("totals", "energy"),
    [
        ((1000.0, 1000.5, 0.0, 1000.6), 0.6),  # a glitch
        ((1000.0, 1000.5, 0.0, 0.0, 0.0, 1000.6), 0.6),
        ((1000.0, 1000.5, 3.0, 1000.4, 1000.6), 0.6),  # back a little lower
        ((1000.0, 1000.5, 0.0, 0.1, 0.2, 1000.7), 0.9),  # a short count of its own, and back
        ((1000.0, 1000.5, 600.0, 1000.6), 0.6),
        ((1000.0, 1000.5, 600.0, 601.0, 1000.6), 1.6),
        ((1000.0, 1000.5, 1000.4, 1000.5, 1000.4, 1000.5, 1000.6), 0.6),  # jitter
        ((5.0, 5.1, 5.0, 5.1, 5.0, 5.2), 0.2),
        ((0.5, 0.4, 0.5, 0.4, 0.6), 0.1),
        ((1000.0, 1000.5, 0.0, 0.4, 1.0), 1.5),  # a reset
        ((1000.0, 1000.5, 0.3, 0.5), 1.0),  # whose first value counts
        ((10.0, 12.0, 0.5, 1.5), 3.5),
        ((3.0, 3.4, 0.4, 0.6), 1.0),  # the counter of a day
        ((1000.0, 1000.5, 0.0, 0.0, 0.0), 0.5),  # a meter that is off
        ((1000.0, 1001.0, 400.0, 401.0, 402.0), 3.0),  # another meter: its first value is no energy
        ((0.0, 0.5, 1.0, 2.0), 2.0),
        ((-1.0, 1.0), 2.0),
    ],
)
def test_a_fall_is_a_reset_only_if_the_total_grows_from_near_zero(totals: tuple[float, ...], energy: float) -> None:
    assert counted(totals) == pytest.approx(energy)


def test_a_counter_that_reaches_its_old_total_again_in_days_has_counted_all_of_it() -> None:
    totals = (10.0, 12.0, 0.0, *(number / 10 for number in range(1, 200)))
    assert counted(totals, every=600_000) == pytest.approx(2.0 + 19.9)


@pytest.mark.parametrize("seed", range(20))
def test_random_glitches_and_jitter_are_no_energy_and_resets_lose_none(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311 - a house
    base, true, totals = chance.uniform(20, 9000), 0.0, list[float]()
    for _ in range(400):
        step = chance.choice((0.0, 0.1, 0.3))
        base, true = base + step, true + step
        kind = chance.random()
        if kind < 0.03:
            totals.append(chance.choice((0.0, base * chance.uniform(0, 0.7))))
        elif kind < 0.3:
            totals.append(base - 0.1)
        elif kind < 0.31 and base > 20:
            totals += [base, 0.0]
            base = 0.0
        totals.append(base)
        if base == 0.0:
            base, true = 0.1, true + 0.1
            totals.append(base)
    assert counted(tuple(totals)) == pytest.approx(true, abs=0.5)


@pytest.mark.virtual_time
async def test_a_glitch_across_an_hour_and_a_restart_is_no_energy(kept: MakeHouse) -> None:
    async with kept(MIDNIGHT + 3590) as house:
        for total in (1000.0, 1000.5, 0.0):
            await house.report("meter", energy=total)
            await anyio.sleep(2)
        await anyio.sleep(3600)
        await house.report("meter", energy=1000.6)
        await house.report("meter", energy=0.0)
        series = await house.read("meter", "energy", points=5000)
        assert min(series.values) == 1000.0
    async with kept(MIDNIGHT + 3 * 3600) as house:
        await house.report("meter", energy=0.0)
        await house.report("meter", energy=1000.7)
        assert [day.used for day in await house.energy()] == [pytest.approx(0.7)]
