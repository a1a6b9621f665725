"""The bounded queue between whoever puts and the one task that reads.

``put`` never blocks: a full mailbox drops its oldest item and counts it in ``lost``. One reader at a time. Not for use
from other threads.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Iterator
from typing import Generic, Protocol, TypeVar

from homebot.errors import ClosedError, UsageError

__all__ = ["KeyedQueue", "Mailbox", "Queue"]

T = TypeVar("T")

MAX_KEYS = 100_000


class Queue(Protocol[T]):
    """What a mailbox keeps its items in."""

    def append(self, item: T, /) -> None:
        """Add *item* at the end."""
        ...

    def popleft(self) -> T:
        """Remove and return the oldest item."""
        ...

    def __len__(self) -> int: ...


class Mailbox(Generic[T]):
    """A bounded queue with one asynchronous reader.

    Attributes:
        queue: The waiting items, oldest first. A publisher appends here itself, see ``Publisher.publish``.
        depth: How many items may wait.
        lost: Items dropped since the start because the mailbox was full.
        waiter: Set while the reader waits for an item; whoever adds one calls :meth:`wake`.
        senders: Those who wait for room; whoever removes an item calls :meth:`admit_sender` when there are any.
    """

    __slots__ = ("_closed", "depth", "lost", "queue", "senders", "waiter")

    def __init__(self, depth: int, key: Callable[[T], Hashable] | None = None) -> None:
        """Make an empty mailbox for *depth* items; with *key*, for *depth* items of each key."""
        self.lost = 0
        self.queue: Queue[T]
        if key is None:
            self.queue, self.depth = deque(), depth
        else:
            self.queue, self.depth = KeyedQueue(depth, key, self._count_lost), depth * MAX_KEYS
        self.waiter: asyncio.Future[None] | None = None
        self.senders: deque[asyncio.Future[None]] = deque()
        self._closed = False

    def put(self, item: T) -> None:
        """Add *item*; a full mailbox drops its oldest item first. After :meth:`close`: nothing happens."""
        if self._closed:
            return
        if len(self.queue) >= self.depth:
            self.drop_oldest()
        self.queue.append(item)
        if self.waiter is not None:
            self.wake()

    def take(self) -> T | None:
        """Return the oldest item, or None when there is none now."""
        if not self.queue:
            return None
        item = self.queue.popleft()
        if self.senders:
            self.admit_sender()
        return item

    async def receive(self) -> T:
        """Return the oldest item, waiting for one.

        Raises:
            ClosedError: The mailbox is closed and empty.
        """
        while not self.queue:
            await self.wait()
        item = self.queue.popleft()
        if self.senders:
            self.admit_sender()
        return item

    async def wait(self) -> None:
        """Wait until an item is there.

        Raises:
            ClosedError: The mailbox is closed and empty.
            UsageError: Another task is waiting already.
        """
        if self.queue:
            return
        if self._closed:
            raise ClosedError("closed")
        if self.waiter is not None:
            raise UsageError("two tasks read from one subscription; give each its own")
        self.waiter = waiter = asyncio.get_running_loop().create_future()
        try:
            await waiter
        finally:
            if self.waiter is waiter:
                self.waiter = None

    async def wait_for_room(self) -> None:
        """Wait until an item can be put without loss, or the mailbox is closed."""
        while len(self.queue) >= self.depth and not self._closed:
            sender = asyncio.get_running_loop().create_future()
            self.senders.append(sender)
            try:
                await sender
            except asyncio.CancelledError:
                if not sender.cancelled():
                    self.admit_sender()  # this one was let in, but does not come
                raise

    def wake(self) -> None:
        """Let the waiting reader run."""
        waiter, self.waiter = self.waiter, None
        if waiter is not None and not waiter.done():
            waiter.set_result(None)

    def admit_sender(self) -> None:
        """Let the first of those who wait for room go on."""
        while self.senders:
            sender = self.senders.popleft()
            if not sender.done():
                sender.set_result(None)
                return

    def drop_oldest(self) -> None:
        """Drop the oldest item and count it as lost."""
        self.queue.popleft()
        self.lost += 1

    def close(self) -> None:
        """End the mailbox: what waits can still be read, nothing more comes in. Twice is fine."""
        self._closed = True
        self.wake()
        while self.senders:
            self.admit_sender()

    def __aiter__(self) -> Mailbox[T]:
        return self

    async def __anext__(self) -> T:
        try:
            return await self.receive()
        except ClosedError:
            raise StopAsyncIteration from None

    def _count_lost(self) -> None:
        self.lost += 1


class KeyedQueue(Generic[T]):
    """A queue that keeps the newest ``depth`` items of each key, all in order of arrival.

    An item that would be one too many for its key drops the oldest item of that key. At most 100,000 keys wait at
    once; one more drops the oldest item of all.
    """

    def __init__(self, depth: int, key: Callable[[T], Hashable], on_loss: Callable[[], None]) -> None:
        self._depth = depth
        self._key = key
        self._on_loss = on_loss
        self._items: OrderedDict[int, T] = OrderedDict()
        self._numbers: dict[Hashable, deque[int]] = {}
        self._next = 0

    def append(self, item: T) -> None:
        """Add *item* at the end."""
        key = self._key(item)
        numbers = self._numbers.get(key)
        if numbers is None:
            if len(self._numbers) >= MAX_KEYS:
                self.popleft()
                self._on_loss()
            numbers = self._numbers[key] = deque()
        elif len(numbers) >= self._depth:
            del self._items[numbers.popleft()]
            self._on_loss()
        numbers.append(self._next)
        self._items[self._next] = item
        self._next += 1

    def popleft(self) -> T:
        """Remove and return the oldest item."""
        _, item = self._items.popitem(last=False)
        key = self._key(item)
        numbers = self._numbers[key]
        numbers.popleft()
        if not numbers:
            del self._numbers[key]
        return item

    def discard(self, key: Hashable) -> None:
        """Forget every item of *key*."""
        for number in self._numbers.pop(key, ()):
            del self._items[number]

    def __len__(self) -> int:
        return len(self._items)

    def __iter__(self) -> Iterator[T]:
        return iter(self._items.values())
