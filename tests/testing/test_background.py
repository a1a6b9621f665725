"""Work beside a test."""

from __future__ import annotations

import anyio
import pytest

from homebot.testing.contexts import in_background


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
