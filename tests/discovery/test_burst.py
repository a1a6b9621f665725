"""The end of a burst of announcements."""

from functools import partial
from itertools import count

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.discovery.publication import Burst

pytestmark = pytest.mark.virtual_time


async def seconds(burst: Burst, *, is_urgent: bool = False) -> float:
    began = anyio.current_time()
    await burst.wait(lambda: is_urgent)
    return round(anyio.current_time() - began, 3)


async def test_the_wait_in_a_burst_that_goes_on_doubles_up_to_a_minute() -> None:
    burst = Burst(LoopClock(), count(1).__next__, partial(anyio.sleep, 0.5))
    assert [await seconds(burst) for _ in range(5)] == [10.0, 20.0, 40.0, 60.0, 60.0]


async def test_the_more_devices_wait_the_longer_a_burst_is_waited_for_up_to_a_minute() -> None:
    waiting = {400: 10.0, 2000: 40.0, 4000: 60.0}
    for devices, longest in waiting.items():
        burst = Burst(LoopClock(), count(1).__next__, partial(anyio.sleep, 0.5), lambda: range(devices))  # noqa: B023
        assert await seconds(burst) == longest


async def test_a_burst_ends_with_a_pause_and_the_next_one_is_waited_for_as_short_as_the_first() -> None:
    announcements = [1]
    burst = Burst(LoopClock(), lambda: announcements[0], partial(anyio.sleep, 0.5))
    assert (await seconds(burst), await seconds(burst)) == (0.5, 0.0)
    announcements[0] = 2
    assert await seconds(burst) == 0.5


async def test_urgent_changes_do_not_wait() -> None:
    burst = Burst(LoopClock(), lambda: 1, partial(anyio.sleep, 0.5))
    assert await seconds(burst, is_urgent=True) == 0.0
