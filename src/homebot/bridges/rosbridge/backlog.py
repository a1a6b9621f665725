"""The frames waiting for clients of the rosbridge server, bounded per topic, per client and in total. No I/O.

A topic over its limit drops its own oldest message, on a keyed topic the oldest of the same key. If a client is over
its limit, the topic with the new message drops its oldest one; if that is its only one, the client's oldest message is
dropped. If all clients together are over the limit, the one with the most waiting loses its oldest message. So a flood
on one topic only affects that topic, and the newest message of each topic stays as long as there is room. Each loss is
counted.
"""

from __future__ import annotations

import sys
import weakref
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Iterator
from typing import TypeAlias, final

from homebot.graph.mailbox import KeyedQueue, keyed_queue
from homebot.graph.subscription import Expiring
from homebot.messages.message import Message
from homebot.messages.numeric_array import NumericArray
from homebot.support.byte_account import ByteAccount

Item: TypeAlias = Message | Expiring[Message]

_OBJECT = 64
"""Bytes of a value in addition to its text."""


@final
class TotalBacklog:
    """The bytes waiting for all clients together.

    Args:
        limit: Most bytes waiting for all clients; above it the client with the most loses its oldest messages.
    """

    def __init__(self, limit: int) -> None:
        self.lost = 0
        self.clients: dict[Backlog, None] = {}
        self._account = ByteAccount(limit, lambda: self.clients, lambda one: one.waiting, lambda one: one.drop_oldest())
        self._last: tuple[weakref.ref[Message] | None, int] = (None, 0)

    @property
    def waiting(self) -> int:
        """Bytes waiting; a message for several clients counts for each."""
        return self._account.used

    def add(self, size: int) -> None:
        """Add *size* bytes, which may be negative; above the limit, the client with the most loses messages."""
        self._account.add(size)

    def weigh(self, message: Message) -> int:
        """Return the bytes of *message*; cached for the next client."""
        last, weight = self._last
        if last is None or last() is not message:
            weight = _weight(message)
            self._last = (weakref.ref(message), weight)
        return weight


@final
class Backlog:
    """The frames waiting for one client.

    Args:
        limit: Maximum number of bytes; one message of any size is allowed.
    """

    def __init__(self, limit: int, everybody: TotalBacklog) -> None:
        self.waiting = 0
        self.everybody = everybody
        self._limit = limit
        self._order: OrderedDict[_Waiting, FeedQueue] = OrderedDict()
        everybody.clients[self] = None

    def add(self, waiting: _Waiting, queue: FeedQueue) -> None:
        """Record *waiting* in *queue*, and drop any excess."""
        self._order[waiting] = queue
        self.waiting += waiting.weight
        while self.waiting > self._limit:
            if len(queue) > 1:
                queue.drop_oldest()
            elif not self.drop_oldest():
                break
        self.everybody.add(waiting.weight)

    def drop_oldest(self) -> bool:
        """Drop the oldest message unless it is the only one; return whether one was dropped."""
        if len(self._order) < 2:
            return False
        next(iter(self._order.values())).drop_oldest()
        return True

    def remove(self, waiting: _Waiting) -> None:
        """Remove *waiting* from the backlog."""
        if self._order.pop(waiting, None) is not None:
            self.waiting -= waiting.weight
            self.everybody.add(-waiting.weight)

    def close(self) -> None:
        """Release everything after the client has left."""
        for queue in set(self._order.values()):
            queue.close()
        self.everybody.clients.pop(self, None)


class _Waiting:
    """A message and its weight; compared by identity."""

    __slots__ = ("item", "weight")

    def __init__(self, item: Item, weight: int) -> None:
        self.item = item
        self.weight = weight


@final
class FeedQueue:
    """The messages of one topic waiting for one client, or kept for it for late subscribers.

    Args:
        depth: Most waiting messages; on a keyed topic, of each key.
        key: Returns the key of a message; None if the topic is not keyed.
    """

    def __init__(
        self,
        depth: int,
        key: Callable[[Item], Hashable] | None,
        backlog: Backlog,
        on_arrival: Callable[[], None],
    ) -> None:
        self.lost = 0
        self._depth = depth if key is None else sys.maxsize
        self._backlog = backlog
        self._on_arrival: Callable[[], None] | None = on_arrival
        self._queue: deque[_Waiting] | KeyedQueue[_Waiting] = deque()
        if key is not None:
            self._queue = keyed_queue(depth, lambda waiting: key(waiting.item), self._record_loss)

    def append(self, item: Item) -> None:
        """Append *item*; any excess is dropped and counted. Ignored after :meth:`close`."""
        if self._on_arrival is None:
            return
        message = item.message if isinstance(item, Expiring) else item
        waiting = _Waiting(item, self._backlog.everybody.weigh(message))
        if len(self._queue) >= self._depth:
            self.drop_oldest()
        self._queue.append(waiting)
        self._backlog.add(waiting, self)
        self._on_arrival()

    def popleft(self) -> Item:
        """Remove and return the oldest message."""
        waiting = self._queue.popleft()
        self._backlog.remove(waiting)
        return waiting.item

    def drop_oldest(self) -> None:
        """Drop the oldest message and count it."""
        self._record_loss(self._queue.popleft())

    def has_room_for(self, _item: object) -> bool:
        """Return True: publishers never wait for a client of the rosbridge server."""
        return True

    def close(self) -> None:
        """Release everything and refuse new messages."""
        self._on_arrival = None
        while self._queue:
            self._backlog.remove(self._queue.popleft())
        self._queue = deque()  # a keyed one holds us

    def __iter__(self) -> Iterator[Item]:
        return iter([waiting.item for waiting in self._queue])

    def __len__(self) -> int:
        return len(self._queue)

    def _record_loss(self, waiting: _Waiting) -> None:
        self._backlog.remove(waiting)
        self._backlog.everybody.lost += 1
        self.lost += 1


def _weight(value: object) -> int:
    if isinstance(value, Message):
        return _OBJECT + sum(_weight(item) for item in value.__dict__.values())
    if isinstance(value, str | bytes):
        return sys.getsizeof(value)
    if isinstance(value, NumericArray):
        return _OBJECT + value.buffer.nbytes
    if isinstance(value, tuple):
        return sys.getsizeof(value) + sum(_weight(item) for item in value)
    return _OBJECT
