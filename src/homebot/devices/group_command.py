"""One command to several handles at once."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable
from typing import TypeVar

import anyio

from homebot.devices.handles.handle import Handle
from homebot.devices.outcomes import Outcome, Refused
from homebot.errors import RefusedError

__all__ = ["give_each"]

HandleT = TypeVar("HandleT", bound=Handle)


async def give_each(
    command: Callable[[HandleT], Coroutine[object, object, Outcome]], handles: Iterable[HandleT]
) -> list[Outcome]:
    """Give *command* to each of *handles*, all at once; return the outcomes in their order."""
    outcomes: dict[int, Outcome] = {}

    async def give(number: int, handle: HandleT) -> None:
        try:
            outcomes[number] = await command(handle)
        except RefusedError as exc:
            outcomes[number] = Refused("device", exc.reason)

    async with anyio.create_task_group() as tasks:
        for number, handle in enumerate(handles):
            tasks.start_soon(give, number, handle)
    return [outcomes[number] for number in sorted(outcomes)]
