"""Work that hangs takes no more threads than its limit, however many callers leave it."""

import threading

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.support.bounded_threads import BoundedThreads


class Hanging:
    """Work that waits for :attr:`gate`."""

    def __init__(self) -> None:
        self.gate = threading.Event()
        self.started = 0
        self._lock = threading.Lock()

    def __call__(self) -> str:
        with self._lock:
            self.started += 1
        assert self.gate.wait(PATIENCE)
        return "done"


async def call_and_leave(threads: BoundedThreads, work: Hanging, count: int, until: int) -> None:
    """Let *count* callers call *work*, and leave once *until* have started in all."""
    async with anyio.create_task_group() as callers:
        for _ in range(count):
            callers.start_soon(threads.run, work)
        with anyio.fail_after(PATIENCE):
            while work.started < until:
                await anyio.lowlevel.checkpoint()
        callers.cancel_scope.cancel()


async def test_a_thread_whose_caller_left_keeps_its_place_until_it_ends() -> None:
    threads, work = BoundedThreads(4, "hanging"), Hanging()
    before = threading.active_count()
    for _ in range(3):
        await call_and_leave(threads, work, 10, until=4)
    assert (work.started, threading.active_count() - before) == (4, 4)
    work.gate.set()
    with anyio.fail_after(PATIENCE):
        assert [await threads.run(work) for _ in range(10)] == ["done"] * 10


async def test_its_error_is_that_of_the_caller_and_gives_the_place_back() -> None:
    threads = BoundedThreads(1, "failing")
    for _ in range(3):
        with pytest.raises(ZeroDivisionError):
            await threads.run(lambda: 1 // 0)
