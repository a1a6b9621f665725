"""Contexts that go on beside a test, and plain logs in it."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import anyio.lowlevel
import pytest
import structlog

from homebot.apps import App
from homebot.testing import VirtualTimeLoop, virtual_house_of
from homebot.testing.contexts import hold_open, in_background, plain_logs


async def test_work_ends_with_the_block() -> None:
    ended = anyio.Event()

    async def work() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            ended.set()

    async with in_background(work):
        await anyio.wait_all_tasks_blocked()
    assert ended.is_set()


async def test_an_error_of_the_block_passes_as_it_is() -> None:
    with pytest.raises(ValueError, match="mine"):
        async with in_background(anyio.sleep_forever):
            raise ValueError("mine")


async def test_an_error_of_the_work_ends_the_block() -> None:
    async def fail() -> None:
        raise ValueError("the work's")

    with pytest.raises(ExceptionGroup) as caught:
        async with in_background(fail):
            await anyio.sleep_forever()
    assert caught.group_contains(ValueError, match="the work's")


@asynccontextmanager
async def worker(said: list[str], *, breaks: bool = False) -> AsyncIterator[list[str]]:
    async def work() -> None:
        await anyio.lowlevel.checkpoint()
        if breaks:
            raise RuntimeError("broken")
        said.append("works")

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(work)
        yield said
    said.append("left")


def test_it_goes_on_whenever_the_loop_does_and_is_left_at_the_end() -> None:
    with asyncio.Runner() as runner:
        with hold_open(runner.get_loop(), worker([])) as said:
            runner.run(anyio.wait_all_tasks_blocked())
            assert said == ["works"]
        assert said == ["works", "left"]


def test_what_cannot_be_entered_says_why() -> None:
    @asynccontextmanager
    async def locked() -> AsyncIterator[None]:
        raise RuntimeError("locked")
        yield

    with (
        asyncio.Runner() as runner,
        pytest.raises(RuntimeError, match="locked"),
        hold_open(runner.get_loop(), locked()),
    ):
        pass


def test_what_breaks_meanwhile_is_told_at_the_end() -> None:
    with (
        asyncio.Runner() as runner,
        pytest.raises(ExceptionGroup) as caught,
        hold_open(runner.get_loop(), worker([], breaks=True)),
    ):
        runner.run(anyio.wait_all_tasks_blocked())
    assert caught.group_contains(RuntimeError, match="broken")


class Broken(App):
    """An app that crashes with something in its variables that is nobody's business."""

    async def run(self) -> None:
        pin = "8" * 4
        raise RuntimeError(f"a pin of {len(pin)} digits")


async def a_house_with_a_crash() -> tuple[str, ...]:
    async with virtual_house_of(f"{Broken.__module__}:{Broken.__qualname__}") as house:
        await house.run_for(1)
        return house.crashed


def test_a_crash_in_a_house_is_told_without_the_variables_and_in_its_time(capsys: pytest.CaptureFixture[str]) -> None:
    structlog.reset_defaults()
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        assert runner.run(a_house_with_a_crash()) == ("broken",)
    told = capsys.readouterr().out
    assert "RuntimeError: a pin of 4 digits" in told
    assert "8888" not in told
    assert "00:00:00  homebot        homebot is running\n" in told
    assert "debug" not in told
    assert not structlog.is_configured()


def test_a_log_that_the_program_has_set_up_is_left_alone() -> None:
    mine = [structlog.processors.KeyValueRenderer()]
    structlog.configure(processors=mine)
    with plain_logs():
        assert structlog.get_config()["processors"] is mine
    assert structlog.get_config()["processors"] is mine


def test_a_log_that_is_set_up_meanwhile_stays() -> None:
    structlog.reset_defaults()
    mine = [structlog.processors.KeyValueRenderer()]
    with plain_logs():
        structlog.configure(processors=mine)
    assert structlog.get_config()["processors"] is mine
