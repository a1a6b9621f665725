"""The output to one client: answers in order, and the messages of its topics.

One task encodes and sends answers and messages alternately, and messages of all topics in turn. Answers are never
dropped: a client that does not accept them is not read from until it does, and is cut off if too many wait
    nevertheless.
"""

from collections import deque
from collections.abc import Awaitable, Callable
from typing import Protocol, final

import anyio

from homebot.bridges.time_slices import ServerTurns

_ANSWER_FACTOR = 4


class MessageSource(Protocol):
    """A topic with messages for the client."""

    def next_frame(self) -> str | bytes | None:
        """Return the next frame, bytes for CBOR; None if there is none."""
        ...


@final
class Outbox:
    """The outgoing frames of one client.

    Args:
        send: Sends a frame, waiting for room; raises LinkError if the client is gone.
        limit: Bytes of waiting answers from which the client is not read from; at four times as many it is cut off.
    """

    def __init__(
        self, send: Callable[[str | bytes], Awaitable[None]], cut: Callable[[], None], turns: ServerTurns, limit: int
    ) -> None:
        self._send = send
        self._cut = cut
        self._turns = turns
        self._limit = limit
        self._answers: deque[str] = deque()
        self._waiting = 0
        self._sources: dict[MessageSource, None] = {}
        self._arrival = anyio.Event()
        self._room = anyio.Event()

    @property
    def has_room(self) -> bool:
        """True if another request of the client may be answered."""
        return self._waiting < self._limit

    def answer(self, frame: str) -> None:
        """Send *frame* as soon as possible."""
        if self._answers and self._waiting + len(frame) > _ANSWER_FACTOR * self._limit:
            self._cut()
            return
        self._answers.append(frame)
        self._waiting += len(frame)
        self._arrival.set()

    def ready(self, source: MessageSource) -> None:
        """Register that *source* has a frame to send."""
        if source not in self._sources:
            self._sources[source] = None
            self._arrival.set()

    async def room(self) -> None:
        """Wait until the client has accepted enough of its answers."""
        while not self.has_room:
            await self._room.wait()

    async def run(self) -> None:
        """Send until cancelled.

        Raises:
            LinkError: The client is gone.
        """
        while True:
            while not self._answers and not self._sources:
                self._arrival = anyio.Event()
                await self._arrival.wait()
            await self._turns.turn()
            if self._answers:
                answer = self._answers.popleft()
                try:
                    await self._send(answer)
                finally:
                    self._waiting -= len(answer)
                if self.has_room:
                    self._room.set()
                    self._room = anyio.Event()
            source = next(iter(self._sources), None)
            if source is not None:
                del self._sources[source]
                frame = source.next_frame()
                if frame is not None:
                    await self._send(frame)
