"""The unanswered requests of one client, and the window of open publishes."""

import asyncio
import math
from collections import deque
from contextvars import Context
from dataclasses import replace
from random import Random
from typing import NamedTuple, TypeAlias, final

from homebot.errors import LinkError
from homebot.mqtt.packets import Publish, Pubrel

Answer: TypeAlias = tuple[int, ...]
"""The raw reason codes of an answer: brokers also send others than the protocol defines."""

_LAST = 65_535


@final
class Requests:
    """The packet identifiers, pending requests and QoS 2 handshakes of one client, over all its links.

    Args:
        random: Chooses the first identifier, so that a restarted process does not reuse identifiers that are open in
            its resumed session.
        timeout: Seconds after which an answer is overdue.
    """

    def __init__(self, random: Random, timeout: float) -> None:
        self._last = random.randrange(_LAST)
        self._timeout = timeout
        self._answers: dict[int, tuple[asyncio.Future[Answer], float]] = {}  # and when each is overdue
        self._check: asyncio.TimerHandle | None = None  # one for all, as nearly every answer comes long before
        self._open: dict[int, _Handshake] = {}  # QoS 2

    def new_id(self) -> int:
        """Return an unused identifier."""
        while True:
            self._last = self._last % _LAST + 1
            if self._last not in self._answers and self._last not in self._open:
                return self._last

    def begin_link(self, *, resumed: bool) -> tuple[Publish | Pubrel, ...]:
        """Return the packets to repeat on a new link: QoS 2 handshakes that the broker may still have.

        An expired handshake is not completed, as many brokers deliver at its end; its identifier is not used again in
        the session.
        """
        if not resumed:
            self._open.clear()
        now = asyncio.get_running_loop().time()
        return tuple(
            request.packet(packet_id, now) for packet_id, request in self._open.items() if request.ends_at > now
        )

    def expect(self, packet_id: int) -> asyncio.Future[Answer]:
        """Wait for the answer to the request *packet_id*, or a TimeoutError; :meth:`forget` it afterwards."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Answer] = loop.create_future()
        overdue = loop.time() + self._timeout
        self._answers[packet_id] = answer, overdue
        if self._check is None:
            self._check = loop.call_at(overdue, self._expire, loop, context=Context())
        return answer

    def forget(self, packet_id: int) -> None:
        """Forget a request."""
        self._answers.pop(packet_id, None)

    def hold(self, packet_id: int, publish: Publish) -> None:
        """Keep a QoS 2 handshake, which continues on later links until the message expires."""
        expiry = publish.properties.message_expiry_interval
        lasts = math.inf if expiry is None else expiry
        self._open[packet_id] = _Handshake(publish, asyncio.get_running_loop().time() + lasts)

    def taken(self, packet_id: int) -> Pubrel:
        """Handle an accepting PUBREC; return the answer."""
        if packet_id in self._open:
            self._open[packet_id] = self._open[packet_id]._replace(publish=None)
        return Pubrel(packet_id)

    def answered(self, packet_id: int, reasons: Answer) -> None:
        """Handle the last answer to *packet_id*; ignored without a waiting caller."""
        self._open.pop(packet_id, None)
        expected = self._answers.get(packet_id)
        if expected is not None and not expected[0].done():
            expected[0].set_result(reasons)

    def fail(self, words: str) -> None:
        """Fail all waiting callers with the reason *words*."""
        for answer, _ in self._answers.values():
            if not answer.done():
                answer.set_exception(LinkError(words))

    def _expire(self, loop: asyncio.AbstractEventLoop) -> None:
        now = loop.time()
        for answer, overdue in self._answers.values():
            if overdue <= now and not answer.done():
                answer.set_exception(TimeoutError())
        later = [overdue for _, overdue in self._answers.values() if overdue > now]
        self._check = loop.call_at(min(later), self._expire, loop, context=Context()) if later else None


class _Handshake(NamedTuple):
    """An unfinished QoS 2 publish; its message is None after PUBREC."""

    publish: Publish | None
    ends_at: float

    def packet(self, packet_id: int, now: float) -> Publish | Pubrel:
        """Return the packet that continues it, with the remaining expiry time."""
        if self.publish is None:
            return Pubrel(packet_id)
        properties = self.publish.properties
        if properties.message_expiry_interval is not None:
            properties = replace(properties, message_expiry_interval=math.ceil(self.ends_at - now))
        return self.publish._replace(dup=True, properties=properties)


@final
class SendWindow:
    """The window of publishes that may be open on a link; others wait in order.

    Waiting callers are released when the link is lost.

    Args:
        size: Initial number of places; below 1, open publishes must end first.
    """

    def __init__(self, size: int) -> None:
        self._free = size
        self._waiters: deque[asyncio.Future[None]] = deque()

    async def acquire(self) -> bool:
        """Wait for a place; return whether there was none at first.

        Raises:
            LinkError: The link was lost while waiting.
        """
        if self._free > 0:
            self._free -= 1
            return False
        waiter = asyncio.get_running_loop().create_future()
        self._waiters.append(waiter)
        try:
            await waiter
        except asyncio.CancelledError:
            if waiter.done() and not waiter.cancelled() and waiter.exception() is None:
                self.release()  # the place became free at the same moment
            raise
        return True

    def release(self) -> None:
        """Free the place of a finished publish."""
        self._free += 1
        while self._free > 0 and self._waiters:
            waiter = self._waiters.popleft()
            if not waiter.done():
                self._free -= 1
                waiter.set_result(None)

    def close(self, words: str) -> None:
        """Fail all waiting callers with the reason *words*."""
        while self._waiters:
            waiter = self._waiters.popleft()
            if not waiter.done():
                waiter.set_exception(LinkError(words))
