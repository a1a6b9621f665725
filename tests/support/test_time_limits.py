"""The time limits of waits that share one timer of the event loop."""

import asyncio
import gc
import math
import weakref
from functools import partial

import anyio
import pytest

from homebot.support.time_limits import TimeLimits

pytestmark = pytest.mark.virtual_time


def now() -> float:
    return asyncio.get_running_loop().time()


async def test_each_wait_that_takes_too_long_is_ended_at_its_own_time() -> None:
    """Also one that was set later and is over sooner than the one that the timer stands at."""
    limits, ended = TimeLimits(), list[tuple[str, float]]()

    def end(name: str) -> None:
        ended.append((name, now()))

    for name, seconds in (("c", 3.0), ("a", 1.0), ("b", 2.0), ("never", math.inf)):
        limits.set(seconds, partial(end, name))

    await anyio.sleep(1000)

    assert ended == [("a", 1.0), ("b", 2.0), ("c", 3.0)]


async def test_a_wait_that_is_over_is_not_ended() -> None:
    """However many of them lie between those that go on."""
    limits, ended = TimeLimits(), list[int]()
    numbers = [limits.set(1.0 + one / 1000, partial(ended.append, one)) for one in range(1000)]
    for number in numbers[1:]:
        limits.discard(number)
    limits.discard(numbers[1])

    await anyio.sleep(10)

    assert ended == [0]


async def test_a_limit_can_be_set_while_others_end() -> None:
    """As by a wait that begins anew where it took too long."""
    limits, ended = TimeLimits(), list[float]()

    def again() -> None:
        ended.append(now())
        if len(ended) < 3:
            limits.set(5.0, again)

    limits.set(5.0, again)
    limits.set(1000.0, again)
    await anyio.sleep(100)

    assert ended == [5.0, 10.0, 15.0]


async def test_an_end_that_raises_costs_no_other_one() -> None:
    """The event loop is told of it."""
    limits, ended, errors = TimeLimits(), list[float](), list[object]()
    asyncio.get_running_loop().set_exception_handler(lambda _, context: errors.append(context["exception"]))
    error = ZeroDivisionError()

    def fail() -> None:
        raise error

    limits.set(1.0, fail)
    limits.set(1.0, lambda: ended.append(now()))
    limits.set(2.0, lambda: ended.append(now()))
    await anyio.sleep(3)

    assert errors == [error]
    assert ended == [1.0, 2.0]


async def test_nothing_of_a_wait_that_is_over_is_held() -> None:
    """Its answer may be a whole house."""

    class Wait:
        def end(self) -> None: ...

    limits, wait = TimeLimits(), Wait()
    held = weakref.ref(wait)
    limits.discard(limits.set(900.0, wait.end))
    del wait
    gc.collect()

    assert held() is None


async def test_no_wait_ends_before_its_time_although_the_loop_rings_early() -> None:
    """Two that wait again for what is left, a step of the clock apart, would wake each other without end."""
    limits, ended = TimeLimits(), list[bool]()
    at = now() + 10.0
    asyncio.get_running_loop().call_at(math.nextafter(at, 0.0), lambda: None)
    limits.set(10.0, lambda: ended.append(now() >= at))

    await anyio.sleep(20)

    assert ended == [True]
