"""Commands given at once, which may share a message to a group."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import count
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from homebot.devices.command_messages import CommandRequest
    from homebot.devices.outcomes import Outcome

_NUMBERS = count(1)


def as_batch(requests: Sequence[CommandRequest]) -> list[CommandRequest]:
    """Return *requests* as commands of one batch, each of which is to be performed at once; one value needs none."""
    batch = {"batch": f"batch-{next(_NUMBERS)}", "batch_size": len(requests)}
    is_one = sum(len(request.settings) for request in requests) < 2
    return list(requests) if is_one else [request.model_copy(update=batch) for request in requests]


async def perform_all(
    perform: Callable[[CommandRequest], Awaitable[Outcome]], requests: Sequence[CommandRequest]
) -> list[Outcome]:
    """Carry out *requests* concurrently as one batch; return their outcomes in order."""
    outcomes: dict[int, Outcome] = {}

    async def carry_out(number: int, request: CommandRequest) -> None:
        outcomes[number] = await perform(request)

    async with anyio.create_task_group() as tasks:
        for number, request in enumerate(as_batch(requests)):
            tasks.start_soon(carry_out, number, request)
    return [outcomes[number] for number in sorted(outcomes)]


class _Open:
    """A batch whose commands are counted while they are given."""

    def __init__(self) -> None:
        self.name, self.size, self.is_full = f"batch-{next(_NUMBERS)}", 0, False


CURRENT_BATCH: ContextVar[_Open | None] = ContextVar("CURRENT_BATCH", default=None)
"""The batch of the tasks that :func:`at_once` began; None outside."""


@contextmanager
def at_once() -> Iterator[None]:
    """Make one batch of the commands with which tasks begin that are started in the block."""
    token = CURRENT_BATCH.set(_Open())
    try:
        yield
    finally:
        CURRENT_BATCH.reset(token)


async def in_batch(request: CommandRequest) -> CommandRequest:
    """Return *request* with the batch of the calling task, once the other tasks have begun too; a task has it once."""
    batch = CURRENT_BATCH.get()
    if batch is None or batch.is_full:
        return request
    CURRENT_BATCH.set(None)
    batch.size += 1
    await asyncio.sleep(0)
    batch.is_full = True
    return request.model_copy(update={"batch": batch.name, "batch_size": batch.size})
