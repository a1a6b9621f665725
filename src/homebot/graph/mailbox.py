"""A bounded queue with any number of writers and one reading task.

``put`` never blocks: a full mailbox drops its oldest item and counts it in ``lost``. The reader yields to other tasks
at least every 256 items. Not thread-safe.
"""

from __future__ import annotations

import asyncio
import sys
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Iterator, Sized
from typing import Generic, Protocol, TypeVar

import anyio.lowlevel

from homebot.errors import ClosedError, UsageError

T = TypeVar("T")

TURN = 256  # items read before a reader that never waits yields to other tasks
MAX_KEYED_ITEMS = 100_000  # over all keys, which external peers choose
_MAX_LIST_DEPTH = 64


class Queue(Protocol[T]):
    """The storage of a mailbox."""

    def append(self, item: T, /) -> None:
        """Add *item* at the end."""
        ...

    def popleft(self) -> T:
        """Remove and return the oldest item."""
        ...

    def __len__(self) -> int: ...


class BoundedQueue(Queue[T], Protocol):
    """A queue that keeps its own bounds."""

    def has_room_for(self, item: T, /) -> bool:
        """Return whether :meth:`append` accepts *item* without dropping another."""
        ...


class Mailbox(Generic[T]):
    """A bounded queue with one asynchronous reader.

    Attributes:
        queue: The waiting items, oldest first. Publishers append directly, see ``Publisher.publish``.
        waiting: Empty if and only if the queue is; faster to test.
        depth: Maximum number of items; keyed and custom queues keep their own bounds.
        waiter: Set while the reader waits; a writer then calls :meth:`wake`.
        senders: Tasks that wait for room; after a removal, call :meth:`admit_senders`.
    """

    __slots__ = ("_closed", "_keyed", "_losses", "_turn", "depth", "queue", "senders", "waiter", "waiting")

    def __init__(
        self, depth: int, key: Callable[[T], Hashable] | None = None, queue: BoundedQueue[T] | None = None
    ) -> None:
        """Create a mailbox for *depth* items, or for *depth* items of each *key*, or with a custom *queue*."""
        self._losses = _Losses()
        keyed = None if key is None else keyed_queue(depth, key, self._losses.add)
        self._keyed: BoundedQueue[T] | None = keyed if queue is None else queue
        self.queue: Queue[T] = deque() if self._keyed is None else self._keyed
        self.waiting: Sized = self.queue if keyed is None or queue is not None else keyed.items
        self.depth = depth if self._keyed is None else sys.maxsize
        self.waiter: asyncio.Future[None] | None = None
        self.senders: deque[asyncio.Future[None]] = deque()
        self._closed = False
        self._turn = 0

    @property
    def lost(self) -> int:
        """Number of items dropped because the mailbox was full; a custom queue counts its own."""
        return self._losses.count

    @lost.setter
    def lost(self, count: int) -> None:
        self._losses.count = count

    def put(self, item: T) -> None:
        """Add *item*, dropping the oldest one if the mailbox is full. A closed mailbox ignores it."""
        if self._closed:
            return
        if self._keyed is None and len(self.queue) >= self.depth:
            self.drop_oldest()
        self.queue.append(item)
        if self.waiter is not None:
            self.wake()

    def take(self) -> T | None:
        """Remove and return the oldest item, or None if the mailbox is empty."""
        if not self.waiting:
            return None
        item = self.queue.popleft()
        if self.senders:
            self.admit_senders()
        return item

    async def receive(self) -> T:
        """Return the oldest item, waiting for one.

        Raises:
            ClosedError: The mailbox is closed and empty.
            UsageError: Another task is waiting already.
        """
        self._turn += 1
        if self._turn >= TURN:
            self._turn = 0
            await anyio.lowlevel.checkpoint()
        while not self.waiting:
            await self.wait()
        item = self.queue.popleft()
        if self.senders:
            self.admit_senders()
        return item

    async def wait(self) -> None:
        """Wait for an item, as :meth:`receive` does."""
        if self.waiting:
            return
        if self._closed:
            raise ClosedError("closed")
        if self.waiter is not None:
            raise UsageError("two tasks read from one subscription; give each task its own")
        self.waiter = waiter = asyncio.get_running_loop().create_future()
        try:
            await waiter
        finally:
            if self.waiter is waiter:
                self.waiter = None

    def has_room_for(self, item: T) -> bool:
        """Return whether :meth:`put` drops no item; always true when closed."""
        if self._closed:
            return True
        return len(self.queue) < self.depth if self._keyed is None else self._keyed.has_room_for(item)

    async def wait_for_change(self) -> None:
        """Wait until an item is removed or the mailbox is closed; then test for room again."""
        sender = asyncio.get_running_loop().create_future()
        self.senders.append(sender)
        try:
            await sender
        except asyncio.CancelledError:
            if sender in self.senders:
                self.senders.remove(sender)
            raise

    def wake(self) -> None:
        """Wake the waiting reader."""
        waiter, self.waiter = self.waiter, None
        if waiter is not None and not waiter.done():
            waiter.set_result(None)

    def admit_senders(self) -> None:
        """Wake all waiting senders, in the order of arrival.

        All, because the first may also wait for another mailbox or another key.
        """
        while self.senders:
            sender = self.senders.popleft()
            if not sender.done():
                sender.set_result(None)

    def drop_oldest(self) -> None:
        """Drop the oldest item and count it as lost."""
        self.queue.popleft()
        self._losses.count += 1

    def close(self) -> None:
        """Stop accepting items; queued ones can still be read. Idempotent."""
        self._closed = True
        self.wake()
        self.admit_senders()

    def clear(self) -> None:
        """Discard all items without counting them as lost."""
        while self.waiting:
            self.queue.popleft()
        self.admit_senders()

    def __aiter__(self) -> Mailbox[T]:
        return self

    async def __anext__(self) -> T:
        try:
            return await self.receive()
        except ClosedError:
            raise StopAsyncIteration from None


class _Losses:
    """The loss counter of a mailbox, a separate object so that its queue forms no reference cycle."""

    __slots__ = ("count",)

    def __init__(self) -> None:
        self.count = 0

    def add(self, _item: object) -> None:
        self.count += 1


class KeyedQueue(Generic[T]):
    """A queue that keeps the newest ``depth`` items of each key, all in order of arrival.

    A full key drops its oldest item. At most 100,000 items are queued over all keys; one more drops the oldest of all.

    Attributes:
        items: The items by sequence number, or by key for depth 1.
    """

    def __init__(self, depth: int, key: Callable[[T], Hashable], on_loss: Callable[[T], None] | None) -> None:
        self._depth = depth
        self._key = key
        self._on_loss = on_loss
        self.items: OrderedDict[Hashable, T] = OrderedDict()
        # Most keys have one or two items, and a deque allocates room for 64.
        self._make_numbers: Callable[[], list[int] | deque[int]] = list if depth <= _MAX_LIST_DEPTH else deque
        self._numbers: dict[Hashable, list[int] | deque[int]] = {}
        self._next = 0

    def append(self, item: T) -> None:
        """Add *item* at the end."""
        key = self._key(item)
        numbers = self._numbers.get(key)
        if numbers is not None and len(numbers) >= self._depth:
            lost = self.items.pop(numbers[0])
            del numbers[0]
            if self._on_loss is not None:
                self._on_loss(lost)
        elif len(self.items) >= MAX_KEYED_ITEMS:
            lost = self.popleft()
            if self._on_loss is not None:
                self._on_loss(lost)
            numbers = self._numbers.get(key)
        if numbers is None:
            numbers = self._numbers[key] = self._make_numbers()
        numbers.append(self._next)
        self.items[self._next] = item
        self._next += 1

    def has_room_for(self, item: T) -> bool:
        """Return whether :meth:`append` accepts *item* without dropping another."""
        return len(self._numbers.get(self._key(item), ())) < self._depth and len(self.items) < MAX_KEYED_ITEMS

    def popleft(self) -> T:
        """Remove and return the oldest item."""
        _, item = self.items.popitem(last=False)
        key = self._key(item)
        numbers = self._numbers[key]
        del numbers[0]
        if not numbers:
            del self._numbers[key]
        return item

    def discard(self, key: Hashable) -> None:
        """Remove every item of *key*."""
        for number in self._numbers.pop(key, ()):
            del self.items[number]

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[T]:
        return iter(self.items.values())


class _NewestOfEach(KeyedQueue[T]):
    """A keyed queue of depth 1, the usual one: items by key."""

    def append(self, item: T) -> None:
        key, items = self._key(item), self.items
        lost = items.pop(key, None)
        if lost is None and len(items) >= MAX_KEYED_ITEMS:
            _, lost = items.popitem(last=False)
        if lost is not None and self._on_loss is not None:
            self._on_loss(lost)
        items[key] = item

    def has_room_for(self, item: T) -> bool:
        return self._key(item) not in self.items and len(self.items) < MAX_KEYED_ITEMS

    def popleft(self) -> T:
        return self.items.popitem(last=False)[1]

    def discard(self, key: Hashable) -> None:
        self.items.pop(key, None)


def keyed_queue(depth: int, key: Callable[[T], Hashable], on_loss: Callable[[T], None] | None = None) -> KeyedQueue[T]:
    """Return a queue for *depth* items of each key, at least one."""
    return (_NewestOfEach if depth == 1 else KeyedQueue)(depth, key, on_loss)
