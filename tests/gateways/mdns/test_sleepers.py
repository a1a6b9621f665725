"""Devices that sleep stay listed, and not for ever; in virtual time."""

from __future__ import annotations

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.gateways.mdns.sleepers import MAX_ASLEEP, Sleepers

pytestmark = pytest.mark.virtual_time


async def test_one_that_sleeps_for_too_long_is_taken_out_once() -> None:
    gone: list[tuple[str, str, float]] = []
    sleepers = Sleepers(LoopClock(), 100.0, lambda name, why: gone.append((name, why, anyio.current_time())))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(sleepers.run)
        begun = anyio.current_time()
        sleepers.add("a")
        await anyio.sleep(60)
        sleepers.add("a")
        sleepers.add("b")
        sleepers.add("c")
        sleepers.discard("c")
        await anyio.sleep(1000)
        tasks.cancel_scope.cancel()
    assert [(name, round(at - begun)) for name, _, at in gone] == [("a", 100), ("b", 160)]
    assert gone[0][1] == "it did not come back from sleep within 100 s"
    assert "a" not in sleepers


async def test_of_too_many_the_one_that_has_slept_longest_is_taken_out() -> None:
    gone: list[str] = []
    sleepers = Sleepers(LoopClock(), 100.0, lambda name, _why: gone.append(name))
    for number in range(MAX_ASLEEP + 2):
        sleepers.add(str(number))
    assert gone == ["0", "1"]
