"""A context that stays open while its loop stands still."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import anyio.lowlevel
import pytest

from homebot.testing.contexts import hold_open


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
