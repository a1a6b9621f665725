"""A blocked event loop is told, with what blocks it; a stray exit ends its task alone."""

import asyncio
import difflib
import sys
import time
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import TypeVar

import pytest
from structlog.testing import capture_logs
from structlog.typing import EventDict

import homebot
from homebot.support import production_loop
from homebot.support.production_loop import LoopWatch, ProductionLoop, own_time

pytestmark = pytest.mark.slow

T = TypeVar("T")


def lived(
    main: Callable[[list[EventDict]], Coroutine[object, object, T]],
) -> tuple[T, LoopWatch, list[EventDict]]:
    """What *main* returns on a loop that counts as blocked after 0.2 s, with its watch and the lines of the log.

    These are given to *main* too, as they come.
    """
    with capture_logs() as lines, asyncio.Runner(loop_factory=ProductionLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, ProductionLoop)
        loop.watch.blocked_after = 0.2
        with loop.watch:
            return runner.run(main(lines)), loop.watch, lines


def watch() -> LoopWatch:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, ProductionLoop)
    return loop.watch


def block_for_half_a_second() -> None:
    """As it is told: where the processor is away for long, that does not count."""
    seen = watch()
    while seen.longest < 0.5:
        pass


def test_all_of_homebot_is_named_where_it_is_installed_among_libraries() -> None:
    assert Path(production_loop._OURS) == Path(homebot.__file__).parent


def test_a_blocked_loop_is_told_once_with_task_and_line_and_at_its_end() -> None:
    async def main(lines: list[EventDict]) -> None:
        task = asyncio.current_task()
        assert task is not None
        task.set_name("/sleeper")
        await asyncio.sleep(0)
        block_for_half_a_second()
        while len(lines) < 2:  # noqa: ASYNC110 - a thread tells nobody
            await asyncio.sleep(0.01)

    _, seen, lines = lived(main)
    assert [line["event"] for line in lines] == ["runtime.loop_blocked", "runtime.loop_free_again"]
    assert "by /sleeper in " in lines[0]["message"]
    assert __file__ in lines[0]["message"]
    assert "(block_for_half_a_second)" in lines[0]["message"]
    assert any("(main)" in place for place in lines[0]["stack"])
    assert lines[1]["seconds"] >= 0.5
    assert seen.blocks == 1


def test_a_library_that_blocks_is_told_by_the_line_that_called_it() -> None:
    async def main(_lines: list[EventDict]) -> None:
        await asyncio.sleep(0)
        seen = watch()
        while not seen.blocks:
            difflib.SequenceMatcher(None, "ab" * 100, "ba" * 100).ratio()

    _, _, lines = lived(main)
    assert f"{__file__}:" in lines[0]["message"]
    assert "(main)" in lines[0]["message"]


def test_a_loop_that_waits_or_works_in_small_pieces_is_not_blocked() -> None:
    async def main(_lines: list[EventDict]) -> None:
        await asyncio.sleep(0.7)
        until = time.monotonic() + 0.7
        while time.monotonic() < until:  # noqa: ASYNC110 - it is to be busy
            await asyncio.sleep(0)

    _, seen, lines = lived(main)
    assert (seen.blocks, lines) == (0, [])


def test_a_task_that_exits_ends_alone_and_is_told() -> None:
    async def leave() -> None:
        sys.exit(3)

    async def main(_lines: list[EventDict]) -> str:
        task = asyncio.create_task(leave())
        asyncio.get_running_loop().call_soon(sys.exit, 4)
        await asyncio.sleep(0.01)
        assert isinstance(task.exception(), SystemExit)
        return "still here"

    result, seen, lines = lived(main)
    assert result == "still here"
    assert seen.exits == 2
    assert "a task called sys.exit(3) in " in lines[0]["message"]
    assert "homebot continues" in lines[0]["message"]


def test_the_exit_of_what_the_loop_runs_for_is_the_end() -> None:
    async def main(_lines: list[EventDict]) -> None:
        await asyncio.sleep(0)
        sys.exit(5)

    with pytest.raises(SystemExit, match="5"):
        lived(main)


def test_an_interrupt_of_any_task_is_the_end() -> None:
    async def interrupt() -> None:
        raise KeyboardInterrupt

    async def main(_lines: list[EventDict]) -> None:
        task = asyncio.create_task(interrupt())
        await task

    with pytest.raises(KeyboardInterrupt):
        lived(main)


@pytest.mark.parametrize(
    ("elapsed", "used", "expected"),
    [
        pytest.param(0.25, 0.0, 0.25, id="it waits for something"),
        pytest.param(3.0, 0.01, 0.25, id="it got no processor"),
        pytest.param(3.0, 3.0, 3.0, id="it worked, and nothing could look meanwhile"),
        pytest.param(0.25, 0.5, 0.25, id="two threads worked"),
    ],
)
def test_time_without_a_processor_does_not_count(elapsed: float, used: float, expected: float) -> None:
    assert own_time(elapsed, used, 0.25) == expected
