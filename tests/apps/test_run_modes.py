"""The modes of a handler: each call ends in a run, a wait or a counted drop, and a failure costs only its run."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from functools import partial

import anyio
import pytest
from structlog.testing import capture_logs

from homebot.apps.run_modes import HandlerRuns, RunMode
from homebot.errors import UsageError
from homebot.graph import Graph, Node
from homebot.graph.current_cause import CURRENT_CAUSE

pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def runs_of(mode: RunMode, most: int = 10) -> AsyncIterator[HandlerRuns]:
    async with Node(Graph(), "hall") as node, anyio.create_task_group() as tasks:
        yield HandlerRuns(node, tasks.start_soon, "handler of the test", mode, most)


def handler(done: list[str], seconds: float = 10.0) -> Callable[[str], Callable[[], Awaitable[None]]]:
    async def work(name: str) -> None:
        done.append(f"{name} began")
        await anyio.sleep(seconds)
        done.append(f"{name} ended")

    return lambda name: partial(work, name)


EXPECTED = {
    "single": (["a began", "a ended"], 2),
    "restart": (["a began", "b began", "c began", "c ended"], 0),
    "queued": (["a began", "a ended", "b began", "b ended"], 1),
    "parallel": (["a began", "b began", "a ended", "b ended"], 1),
}


@pytest.mark.parametrize("mode", EXPECTED)
async def test_a_call_while_another_runs_goes_by_the_mode(mode: RunMode) -> None:
    """The one that is dropped is counted."""
    done: list[str] = []
    async with runs_of(mode, most=2) as runs:
        for name in "abc":
            runs.start(handler(done)(name))
            await anyio.sleep(1)
        assert runs.running_since is not None
    assert (done, runs.dropped) == EXPECTED[mode]
    assert runs.running_since is None


@pytest.mark.parametrize("mode", ["queued", "parallel"])
async def test_calls_at_one_moment_stop_at_most(mode: RunMode) -> None:
    """Also before the first of them had its turn."""
    done: list[str] = []
    async with runs_of(mode, most=3) as runs:
        assert [runs.start(handler(done)(str(number))) for number in range(5)] == [True, True, True, False, False]
    assert len(done) == 6


async def test_a_plain_function_may_return_a_value() -> None:
    """It is no failure, of which five would end the handler."""
    async with runs_of("single") as runs:
        runs.start(lambda: True)  # type: ignore[arg-type, return-value]  # what is under test
    assert runs.failures == 0


async def test_many_dropped_calls_are_one_line() -> None:
    """A sensor that reports all day does not fill the log."""
    with capture_logs() as lines:
        async with runs_of("single") as runs:
            for _ in range(100):
                runs.start(handler([], seconds=1000)("a"))
    assert runs.dropped == 99
    assert [line["message"] for line in lines] == ["the handler of the test was not called: its last call still runs"]


async def test_each_run_has_the_cause_of_its_call() -> None:
    """Also one that waited for its turn behind another."""
    causes: list[object] = []

    async def work() -> None:
        await anyio.sleep(1)
        causes.append(CURRENT_CAUSE.get())

    async with runs_of("queued") as runs:
        runs.start(work, "first")
        runs.start(work, "second")
    assert causes == ["first", "second"]


async def test_a_handler_that_fails_five_times_in_a_row_is_given_up() -> None:
    """A success in between counts anew, and a plain function is a handler as well."""
    results = [ValueError("odd"), ValueError("odd"), None, *[ValueError("odd")] * 5, None]

    def work() -> None:
        if (result := results.pop(0)) is not None:
            raise result

    async with runs_of("single") as runs:
        for _ in range(10):
            runs.start(work)
            await anyio.sleep(1)
        assert runs.trouble == "failed 5 times in a row and is not called any more (ValueError: odd)"
    assert results == [None]


async def test_the_fifth_failure_is_logged_and_the_traceback_of_one_wrong_line_once() -> None:
    """Within ten seconds: the log said that the handler continues, and then nothing."""

    def work() -> None:
        raise ValueError("odd")

    async with runs_of("single") as runs:
        with capture_logs() as lines:
            for _ in range(6):
                runs.start(work)
                await anyio.sleep(0.1)
    first, last = lines
    begin = "the handler of the test failed (ValueError: odd); it"
    assert first["message"] == f"{begin} is called again, up to 5 failures in a row"
    assert last["message"] == f"{begin} was the 5th time in a row, and it is not called until the app is restarted"
    assert ("exc_info" in first, "exc_info" in last) == (True, False)


@pytest.mark.parametrize("error", [SystemExit(1), GeneratorExit(), asyncio.CancelledError()])
async def test_an_error_that_would_end_a_task_costs_one_run(error: BaseException) -> None:
    done: list[str] = []

    async def work() -> None:
        raise error

    async with runs_of("queued") as runs:
        runs.start(work)
        runs.start(handler(done)("next"))
    assert done == ["next began", "next ended"]
    assert runs.failures == 0


async def test_a_run_that_is_cancelled_is_no_failure() -> None:
    done: list[str] = []
    async with runs_of("queued") as runs:
        runs.start(handler(done)("a"))
        runs.start(handler(done)("b"))
        await anyio.sleep(1)
        runs.cancel()
        await anyio.sleep(1)
        runs.start(handler(done)("c"))
    assert (done, runs.failures) == (["a began", "c began", "c ended"], 0)


async def test_a_mode_that_does_not_exist_is_named() -> None:
    node = Node(Graph(), "hall")
    with pytest.raises(UsageError, match="mode: there is no 'paralel'; did you mean parallel"):
        HandlerRuns(node, lambda _: None, "job", "paralel")  # type: ignore[arg-type]  # what is under test
    with pytest.raises(UsageError, match="most: 0 is not a number from 1 on"):
        HandlerRuns(node, lambda _: None, "job", "queued", 0)
