"""Timers: a steady rate, skipping what was missed."""

import asyncio
import math

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.errors import UsageError
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time


def now() -> float:
    return asyncio.get_running_loop().time()


class SlowComputer:
    """Time passes between one line of the program and the next."""

    def __init__(self) -> None:
        self._clock = LoopClock()
        self._spent = 0.0

    def now(self) -> float:
        return self._clock.now() + self._spent

    def monotonic(self) -> float:
        self._spent += 0.6
        return self._clock.monotonic() + self._spent


async def test_one_that_is_late_already_does_not_sleep() -> None:
    calls: list[float] = []
    async with Node(Graph(SlowComputer()), "busy") as node:
        node.create_timer(1, lambda: calls.append(now()))
        await anyio.sleep(3)
    assert len(calls) > 3


async def test_it_calls_once_per_period_the_first_time_after_one(node: Node) -> None:
    calls: list[float] = []
    node.create_timer(10, lambda: calls.append(now()))
    await anyio.sleep(35)
    assert calls == [10, 20, 30]


async def test_it_does_not_drift_however_long_the_callback_takes(node: Node) -> None:
    calls: list[float] = []

    async def slow() -> None:
        calls.append(now())
        await anyio.sleep(0.9)

    timer = node.create_timer(1, slow)
    await anyio.sleep(1000.5)
    assert calls == [float(second) for second in range(1, 1001)]
    assert timer.skipped == 0


async def test_the_rate_holds_over_a_day_of_fractions(node: Node) -> None:
    calls: list[float] = []
    node.create_timer(0.7, lambda: calls.append(now()))
    await anyio.sleep(7000.35)
    assert len(calls) == 10_000


async def test_periods_missed_while_the_callback_runs_are_skipped_and_counted(node: Node) -> None:
    calls: list[float] = []

    async def slow_once() -> None:
        calls.append(now())
        if len(calls) == 1:
            await anyio.sleep(35)

    timer = node.create_timer(10, slow_once)
    await anyio.sleep(65)
    assert calls == [10, 50, 60]
    assert timer.skipped == 3


async def test_made_before_its_node_runs_it_starts_with_the_node(graph: Graph) -> None:
    calls: list[float] = []
    node = Node(graph, "late")
    node.create_timer(10, lambda: calls.append(now()))
    await anyio.sleep(100)
    async with node:
        await anyio.sleep(15)
    await anyio.sleep(100)
    assert calls == [110]


async def test_a_cancelled_timer_calls_no_more(node: Node) -> None:
    calls: list[float] = []
    timer = node.create_timer(10, lambda: calls.append(now()))
    await anyio.sleep(15)
    assert not timer.is_canceled
    timer.cancel()
    timer.cancel()
    await anyio.sleep(100)
    assert timer.is_canceled
    assert calls == [10]


async def test_a_timer_cancelled_before_it_runs_never_calls(graph: Graph) -> None:
    calls: list[float] = []
    node = Node(graph, "early")
    node.create_timer(10, lambda: calls.append(now())).cancel()
    async with node:
        await anyio.sleep(100)
    assert calls == []


async def test_a_callback_may_cancel_its_timer_and_is_finished(node: Node) -> None:
    calls: list[float] = []

    async def once() -> None:
        timer.cancel()
        await anyio.sleep(1)
        calls.append(now())

    timer = node.create_timer(10, once)
    await anyio.sleep(100)
    assert calls == [11]


async def test_the_period_can_be_changed(node: Node) -> None:
    calls: list[float] = []
    timer = node.create_timer(10, lambda: calls.append(now()))
    await anyio.sleep(15)
    timer.period = 2
    await anyio.sleep(10)
    assert timer.period == 2
    assert calls == [10, 20, 22, 24]


@pytest.mark.parametrize("period", [0, -1, math.nan])
async def test_a_period_must_be_above_zero(node: Node, period: float) -> None:
    with pytest.raises(UsageError, match=f"above 0, got {period}"):
        node.create_timer(period, lambda: None)
    timer = node.create_timer(1, lambda: None)
    with pytest.raises(UsageError, match=f"above 0, got {period}"):
        timer.period = period
