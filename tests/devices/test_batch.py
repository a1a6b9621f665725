"""Batches: the commands that are given in one turn of the event loop; in virtual time."""

import anyio
import pytest

from homebot.devices.batch import as_batch, at_once, in_batch
from homebot.devices.command_messages import CommandRequest, Setting

pytestmark = pytest.mark.virtual_time

REQUEST = CommandRequest(device="lamp", settings=(Setting.of("on_off", True),), issuer="/app")


async def test_tasks_that_begin_with_a_command_give_one_batch_and_a_later_one_is_by_itself() -> None:
    found: list[CommandRequest] = []

    async def give(after: float) -> None:
        if after:
            await anyio.sleep(after)
        found.append(await in_batch(REQUEST))
        found.append(await in_batch(REQUEST))

    async with anyio.create_task_group() as tasks:
        with at_once():
            for after in (0.0, 0.0, 1.0):
                tasks.start_soon(give, after)
        tasks.start_soon(give, 0.0)
    assert sorted(one.batch_size for one in found) == [0, 0, 0, 0, 0, 0, 2, 2]
    assert len({one.batch for one in found}) == 2


async def test_a_command_that_no_other_is_given_with_is_no_batch() -> None:
    assert as_batch([REQUEST]) == [REQUEST]
    assert [one.batch_size for one in as_batch([REQUEST, REQUEST])] == [2, 2]
