"""Calls over one link, each of which waits for its answer."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from itertools import count
from typing import Final, Generic, NoReturn, TypeVar

import anyio
import anyio.lowlevel

from homebot.errors import LinkError
from homebot.support.unanswered import awaiting_answer

Answer = TypeVar("Answer")


@dataclass(eq=False, slots=True)
class _PendingCall(Generic[Answer]):
    on_answer: Callable[[Answer], Awaitable[None]] | None
    answered: anyio.Event = field(default_factory=anyio.Event)
    answer: Answer | None = None


MAX_CALLS: Final = 100
"""Calls that may wait at once; a further one is refused."""


class PendingCalls(Generic[Answer]):
    """The calls over one link that wait for their answers; ids tell which answer belongs to which call."""

    def __init__(self, peer: str) -> None:
        self._peer = peer
        self._pending: dict[str, _PendingCall[Answer]] = {}
        self._numbers = count(1)
        self._is_lost = False

    def __len__(self) -> int:
        return len(self._pending)

    def new_id(self) -> str:
        """Return an id that no other call has: a number as text."""
        return str(next(self._numbers))

    async def call(
        self,
        what: str,
        send: Callable[[str], Awaitable[None]],
        within: float,
        on_answer: Callable[[Answer], Awaitable[None]] | None = None,
    ) -> Answer:
        """Send a call, and return its answer.

        Args:
            on_answer: Receives the answer before the task that brought it goes on.

        Raises:
            LinkError: The link is lost, there was no answer in time, or too many calls wait.
        """
        if len(self) >= MAX_CALLS:
            raise LinkError(f"{what}: {MAX_CALLS} commands are waiting for {self._peer} already")
        if self._is_lost:
            await self._fail()
        call_id = self.new_id()
        call = self._pending[call_id] = _PendingCall[Answer](on_answer)
        try:
            with awaiting_answer(), anyio.fail_after(within):
                await send(call_id)
                await call.answered.wait()
                return call.answer if call.answer is not None else await self._fail()
        except TimeoutError:
            raise LinkError(f"{self._peer} did not answer {what} within {within:g} s") from None
        finally:
            del self._pending[call_id]

    async def resolve(self, call_id: str, answer: Answer) -> bool:
        """Complete a call with its answer; return False if no call of that id waits."""
        call = self._pending.get(call_id)
        if call is None or call.answer is not None:
            return False
        call.answer = answer
        try:
            if call.on_answer is not None:
                await call.on_answer(answer)
        finally:
            call.answered.set()
        return True

    def end(self) -> None:
        """Fail waiting and later calls: the link is lost."""
        self._is_lost = True
        for call in self._pending.values():
            call.answered.set()

    async def _fail(self) -> NoReturn:
        await anyio.lowlevel.checkpoint()  # where the caller is cancelled together with the link, it was not lost
        raise LinkError(f"the connection to {self._peer} was lost")
