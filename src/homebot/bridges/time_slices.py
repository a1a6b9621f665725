"""The turns of a server's tasks within its turn budget."""

import asyncio
import time
from collections.abc import Callable, Generator
from typing import TypeVar, final

from homebot.support.turn_budget import TurnBudget

T = TypeVar("T")


@final
class ServerTurns:
    """The turns of a server; a piece of work is the part of a task between two of them."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._budget = TurnBudget(now, lambda call: asyncio.get_running_loop().call_soon(call))
        self.has_time = self._budget.has_time
        self.defer = self._budget.defer

    async def turn(self) -> None:
        """Wait until work may begin."""
        if self.has_time():
            return
        waiter: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.defer(lambda: _wake(waiter))
        await waiter

    async def run(self, steps: Generator[None, None, T]) -> T:
        """Return the result of *steps*, each a separate piece of work."""
        while True:
            try:
                next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            await self.turn()


def _wake(waiter: asyncio.Future[None]) -> bool:
    if waiter.done():  # cancelled in the meantime
        return False
    waiter.set_result(None)
    return True
