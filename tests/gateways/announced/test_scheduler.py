"""Callbacks are called at their time, and there is room for so many only."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial

import anyio
import anyio.lowlevel
import pytest

from homebot.clock import LoopClock, ManualClock
from homebot.gateways.announced.scheduler import Scheduler

pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def running(most: int = 3) -> AsyncIterator[Scheduler]:
    scheduler = Scheduler(LoopClock(), most)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(scheduler.run)
        yield scheduler
        tasks.cancel_scope.cancel()


@pytest.fixture
def called() -> list[str]:
    return []


@pytest.fixture
def note(called: list[str]) -> Callable[[str], Callable[[], None]]:
    """Makes callbacks that write down their name and the time."""
    return lambda name: lambda: called.append(f"{name} at {anyio.current_time():g}")


async def test_each_is_called_once_at_its_time_and_what_is_dropped_is_not(
    called: list[str], note: Callable[[str], Callable[[], None]]
) -> None:
    async with running() as scheduler:
        scheduler.plan("late", 5.0, note("late"))
        scheduler.plan("moved", 9.0, note("before"))
        scheduler.plan("dropped", 1.0, note("dropped"))
        await anyio.sleep(0.5)
        scheduler.plan("moved", 1.5, note("moved"))  # earlier than what the task waits for
        scheduler.drop("dropped")
        scheduler.drop("unknown")
        await anyio.sleep(20.0)
    assert called == ["moved at 2", "late at 5"]


async def test_there_is_room_for_so_many_only_but_always_for_a_new_time(
    called: list[str], note: Callable[[str], Callable[[], None]]
) -> None:
    async with running(most=3) as scheduler:
        assert all(scheduler.plan(name, 1.0, note(name)) for name in "abc")
        assert not scheduler.plan("d", 1.0, note("d"))
        assert scheduler.plan("a", 2.0, note("a"))
        await anyio.sleep(1.5)
        assert scheduler.plan("d", 1.0, note("d"))
        await anyio.sleep(5.0)
    assert called == ["b at 1", "c at 1", "a at 2", "d at 2.5"]


async def test_others_get_their_turn_after_a_few_milliseconds_of_work_however_much_is_due() -> None:
    clock = ManualClock()
    scheduler = Scheduler(clock)
    costs = [0.003] * 20 + [0.0001] * 280
    done: list[float] = []

    def work(cost: float) -> None:
        clock.advance(cost)
        done.append(cost)

    for number, cost in enumerate(costs):
        scheduler.plan(number, 0.0, partial(work, cost))
    waits: list[float] = []
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(scheduler.run)
        while len(done) < len(costs) and len(waits) < 1000:
            began = clock.monotonic()
            await anyio.lowlevel.checkpoint()
            waits.append(clock.monotonic() - began)
        tasks.cancel_scope.cancel()
    assert done == costs
    assert max(waits) < 0.009
