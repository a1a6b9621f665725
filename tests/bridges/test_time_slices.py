"""The door's share of the event loop: everybody's turn comes, and everything else runs in between."""

import anyio
import anyio.lowlevel
import pytest

from homebot.bridges.time_slices import ServerTurns


class WorkClock:
    """Goes on while somebody works, and only then."""

    def __init__(self) -> None:
        self.now = 0.0

    def work(self) -> None:
        self.now += 0.006  # more than the share


@pytest.fixture
def clock() -> WorkClock:
    return WorkClock()


@pytest.fixture
def turns(clock: WorkClock) -> ServerTurns:
    return ServerTurns(lambda: clock.now)


async def test_whoever_works_long_lets_everything_else_run_in_between(turns: ServerTurns, clock: WorkClock) -> None:
    rounds = 0

    async def count_rounds() -> None:
        nonlocal rounds
        while True:
            await anyio.lowlevel.checkpoint()
            rounds += 1

    async def flood() -> None:
        for _ in range(5):
            await turns.turn()
            clock.work()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(count_rounds)
        async with anyio.create_task_group() as floods:
            for _ in range(4):
                floods.start_soon(flood)
        assert rounds >= 19  # of 20 pieces of work each but the first waited for a round of its own
        tasks.cancel_scope.cancel()


async def test_turns_go_round_in_the_order_of_asking(turns: ServerTurns, clock: WorkClock) -> None:
    got: list[str] = []

    async def worker(name: str) -> None:
        for _ in range(3):
            await turns.turn()
            got.append(name)
            clock.work()

    async with anyio.create_task_group() as tasks:
        turns.defer(clock.work)
        for name in "abc":
            tasks.start_soon(worker, name)
    assert "".join(got) == "abcabcabc"


async def test_a_cancelled_waiter_costs_no_turn(turns: ServerTurns, clock: WorkClock) -> None:
    got: list[str] = []

    async def worker(name: str) -> None:
        await turns.turn()
        got.append(name)

    async with anyio.create_task_group() as tasks, anyio.create_task_group() as gone:
        for _ in range(50):
            turns.defer(clock.work)
        gone.start_soon(worker, "gone")
        await anyio.lowlevel.checkpoint()
        tasks.start_soon(worker, "b")
        gone.cancel_scope.cancel()
    assert got == ["b"]


async def test_little_work_waits_for_nothing(turns: ServerTurns) -> None:
    for _ in range(10):
        assert turns.has_time()
