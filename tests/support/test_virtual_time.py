"""The event loop whose time jumps."""

import asyncio
import re
import socket
import threading
from collections.abc import Awaitable, Callable
from functools import partial

import anyio
import anyio.lowlevel
import anyio.to_thread
import pytest

from homebot.errors import UsageError
from homebot.support.virtual_time import LoopLimits
from homebot.testing import VirtualTimeLoop

pytestmark = pytest.mark.virtual_time


async def test_a_year_passes_at_once_and_every_timer_fires_at_its_own_time() -> None:
    loop = asyncio.get_running_loop()
    fired: list[float] = []

    async def note(seconds: float) -> None:
        await anyio.sleep(seconds)
        fired.append(loop.time())

    async with anyio.create_task_group() as tasks:
        for seconds in (31_536_000.0, 0.001, 60.0):
            tasks.start_soon(note, seconds)
    assert fired == [0.001, 60.0, pytest.approx(31_536_000.0)]


async def test_what_is_ready_runs_before_time_passes() -> None:
    loop = asyncio.get_running_loop()
    for _ in range(1_000):
        await asyncio.sleep(0)
    assert loop.time() == 0.0


async def test_settled_comes_after_all_that_is_due_now_and_before_time_passes() -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    done: list[str] = []

    async def work(name: str, seconds: float) -> None:
        await asyncio.sleep(seconds)
        for _ in range(100):
            await asyncio.sleep(0)
        done.append(name)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(work, "now", 0.0)
        tasks.start_soon(work, "then", 5.0)
        await loop.settled()
        assert (done, loop.time()) == (["now"], 0.0)
        await asyncio.sleep(5.0)
        await loop.settled()
        assert (done, loop.time()) == (["now", "then"], 5.0)


async def test_several_may_wait_until_all_is_settled_and_one_may_give_up() -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(loop.settled)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await loop.settled()
        await loop.settled()


async def test_a_time_limit_is_virtual_too() -> None:
    with pytest.raises(TimeoutError):
        with anyio.fail_after(3_600):
            await anyio.sleep_forever()
    assert asyncio.get_running_loop().time() == 3_600


async def test_the_shortest_sleep_ends_even_where_a_float_is_coarse() -> None:
    await asyncio.sleep(2.0**25)
    await asyncio.sleep(1e-9)
    await asyncio.sleep(1e-3)
    assert asyncio.get_running_loop().time() == pytest.approx(2.0**25)


async def test_what_a_socket_brings_comes_before_the_next_timer() -> None:
    reading, writing = socket.socketpair()
    with reading, writing:
        reading.setblocking(False)
        writing.send(b"x")
        async with asyncio.timeout(1):
            assert await asyncio.get_running_loop().sock_recv(reading, 1) == b"x"


async def test_another_thread_can_wake_a_loop_without_timers() -> None:
    done = asyncio.Event()
    thread = threading.Thread(target=asyncio.get_running_loop().call_soon_threadsafe, args=(done.set,))
    thread.start()
    await done.wait()
    thread.join()


@pytest.mark.parametrize("run", [anyio.to_thread.run_sync, asyncio.to_thread])
async def test_no_time_passes_while_a_worker_thread_works(run: Callable[[Callable[[], bool]], Awaitable[bool]]) -> None:
    loop = asyncio.get_running_loop()
    has_slept = threading.Event()
    seen: list[float] = []

    async def work() -> None:
        assert await run(partial(has_slept.wait, 0.05)) is False  # the timer below is far beyond what this takes
        seen.append(loop.time())

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(work)
        await anyio.sleep(3_600.0)
        has_slept.set()
    assert seen == [0.0]


async def test_settled_comes_after_what_a_worker_thread_does() -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualTimeLoop)
    done: list[bool] = []

    async def work() -> None:
        done.append(await anyio.to_thread.run_sync(threading.Event().wait, 0.05))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(work)
        await loop.settled()
        assert done == [False]


async def test_a_thread_with_a_limiter_of_its_own_holds_no_time_up() -> None:
    has_passed = threading.Event()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(partial(anyio.to_thread.run_sync, has_passed.wait, limiter=anyio.CapacityLimiter(1)))
        await anyio.sleep(60.0)
        has_passed.set()


def test_a_worker_thread_that_never_ends_is_an_error() -> None:
    has_ended = threading.Event()

    async def wait() -> None:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(partial(anyio.to_thread.run_sync, has_ended.wait, 30.0))
            await anyio.sleep(60.0)

    runner = asyncio.Runner(loop_factory=lambda: VirtualTimeLoop(LoopLimits(thread_stuck_after=1.0)))
    with pytest.raises(UsageError, match="a worker thread has worked"):
        runner.run(wait())
    has_ended.set()
    runner.close()


def test_waiting_for_what_cannot_come_is_an_error() -> None:
    with (
        asyncio.Runner(loop_factory=lambda: VirtualTimeLoop(LoopLimits(stuck_after=0.0))) as runner,
        pytest.raises(UsageError, match="nothing is ready and no timer is set"),
    ):
        runner.run(anyio.sleep_forever())


def test_a_program_that_is_always_busy_ends_with_the_name_of_what_is() -> None:
    async def never_waits() -> None:
        while True:
            await anyio.lowlevel.checkpoint()

    async def program() -> None:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(never_waits, name="the hot one")
            await anyio.sleep(1)

    limits = LoopLimits(hot_after=0.05, hot_turns=1_000)
    told = rf"virtual time cannot advance: .*; now: the hot one in .*never_waits, {re.escape(__file__)}:\d+$"
    loop = VirtualTimeLoop(limits)
    with asyncio.Runner(loop_factory=lambda: loop) as runner, pytest.raises(UsageError, match=told):
        runner.run(program())


def test_a_busy_program_that_comes_to_rest_each_time_goes_on() -> None:
    async def program(loop: VirtualTimeLoop) -> float:
        for _ in range(100):
            for _ in range(100):
                await asyncio.sleep(0)
            await loop.settled()
        return loop.time()

    loop = VirtualTimeLoop(LoopLimits(hot_after=0.0, hot_turns=1_000))
    with asyncio.Runner(loop_factory=lambda: loop) as runner:
        assert runner.run(program(loop)) == 0.0
