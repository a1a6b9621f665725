"""The guard that every test stands under: code of homebot must not block the event loop."""

from __future__ import annotations

import time

import pytest
from blockbuster import BlockingError

import homebot

BLOCKING = "import time; time.sleep(0)"


async def test_code_of_homebot_that_blocks_the_loop_is_caught() -> None:
    with pytest.raises(BlockingError, match=r"time\.sleep"):
        exec(compile(BLOCKING, homebot.__file__, "exec"))  # noqa: S102  # as if it stood in the package


async def test_code_of_a_test_may_block() -> None:
    time.sleep(0)  # noqa: ASYNC251  # what is under test


def test_without_a_loop_anything_may_block() -> None:
    exec(compile(BLOCKING, homebot.__file__, "exec"))  # noqa: S102  # as if it stood in the package
