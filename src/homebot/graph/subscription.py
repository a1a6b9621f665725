"""The reading end of a topic."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Hashable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Final, Generic, TypeAlias, TypeVar, final

import anyio
import anyio.lowlevel

from homebot.clock import Clock
from homebot.errors import ClosedError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.mailbox import TURN, BoundedQueue, Mailbox
from homebot.graph.qos import QoSProfile
from homebot.isolation import is_end_of
from homebot.messages.message import Message

__all__ = ["OTHERS", "Callback", "Expiring", "Subscription", "key_of"]

MessageT = TypeVar("MessageT", bound=Message)
T = TypeVar("T")

Callback: TypeAlias = Callable[[MessageT], Awaitable[None] | None]


@final
@dataclass(frozen=True, slots=True)
class Expiring(Generic[T]):
    """A queued message whose publisher gave it a lifespan.

    Attributes:
        message: The message.
        expires_at: Reading of the monotonic clock from which on it is not delivered.
    """

    message: T
    expires_at: float

    def __getattr__(self, name: str) -> object:
        """Return a field of the message, so that its key is read as that of a message without a lifespan."""
        return getattr(self.message, name)


OTHERS: Final = "others"
"""In the place of the name of a node: all but the one that subscribes, as by ROS's ``ignore_local_publications``."""


class Subscription(Generic[MessageT]):
    """Reads messages of one type from one topic: ``async for message in subscription``, or a callback.

    Attributes:
        info: The endpoint as the graph shows it.
        qos: The quality of service that it requests.
        from_node: The full name of the only node whose messages it receives; empty for all nodes, :data:`OTHERS` for
            all but its own.
        mailbox: The waiting messages.
        incompatible_qos_count: The number of publishers that offer less than it requests.
        expired: The number of messages not delivered because their lifespan had passed.
        unbegun: The number of messages that were taken out, each by a task that has not begun to handle it.
    """

    def __init__(
        self,
        topic: str,
        message_type: type[MessageT],
        node: str,
        qos: QoSProfile,
        clock: Clock,
        on_close: Callable[[], None],
        on_failure: Callable[[BaseException], None],
        from_node: str = "",
        queue: BoundedQueue[MessageT | Expiring[MessageT]] | None = None,
    ) -> None:
        """Take what :meth:`homebot.graph.Node.create_subscription` gives; not for use by hand."""
        self.info = EndpointInfo(EntityKind.SUBSCRIPTION, node, topic, message_type.ros_type, qos)
        self.qos = qos
        self.from_node = from_node
        self.incompatible_qos_count = 0
        self.expired = 0
        self.unbegun = 0
        self._is_keyed = message_type.key_field is not None
        self._on_close: Callable[[], None] | None = on_close
        self._on_failure = on_failure
        self._closed = False
        self._is_abandoned = False  # what called back has ended, so nobody reads the rest
        self._clock = clock
        self.mailbox: Mailbox[MessageT | Expiring[MessageT]] = Mailbox(
            qos.queue_depth, key_of(message_type) if queue is None else None, queue
        )

    @property
    def topic_name(self) -> str:
        """Full name of the topic."""
        return self.info.name

    @property
    def lost(self) -> int:
        """Messages dropped since the start because the queue was full."""
        return self.mailbox.lost

    @property
    def wants_all(self) -> bool:
        """True if each message counts, and not only the newest, of all or of each key."""
        return self.qos.queue_depth > 1 and not self._is_keyed

    def take(self) -> MessageT | None:
        """Return the oldest waiting message, or None when there is none now."""
        while (item := self.mailbox.take()) is not None:
            if not isinstance(item, Expiring):
                return item
            if (message := self._unexpired(item)) is not None:
                return message
        return None

    async def receive(self) -> MessageT:
        """Return the oldest message, waiting for one.

        Raises:
            ClosedError: The subscription is closed and everything was read.
            UsageError: Another task is reading already.
        """
        while True:
            item = await self.mailbox.receive()
            if not isinstance(item, Expiring):
                return item
            if (message := self._unexpired(item)) is not None:
                return message

    def __aiter__(self) -> Subscription[MessageT]:
        return self

    async def __anext__(self) -> MessageT:
        try:
            return await self.receive()
        except ClosedError:
            raise StopAsyncIteration from None

    def close(self) -> None:
        """Leave the topic and end the iteration once the queue is read empty. Twice is fine."""
        if not self._closed:
            self._closed = True
            # The callback holds the subscription: kept, the two would stay in memory with all unread messages.
            on_close, self._on_close = self._on_close, None
            if on_close is not None:
                on_close()
            self.mailbox.close()
            if self._is_abandoned:
                self.mailbox.clear()

    async def run_in_turn(self, callback: Callback[MessageT]) -> None:
        """Call *callback* with every message until the subscription is closed; the node's task does this.

        The next message waits until the callback is done. A callback that fails costs its message.
        """
        mailbox = self.mailbox
        take, waiting, senders = mailbox.queue.popleft, mailbox.waiting, mailbox.senders
        task = asyncio.current_task()
        try:
            while True:
                await mailbox.wait()
                for _ in range(TURN):
                    if not waiting:
                        break
                    item = take()
                    if senders:
                        mailbox.admit_senders()
                    if type(item) is Expiring:
                        message = self._unexpired(item)
                        if message is None:
                            continue
                    else:
                        message = item
                    try:
                        result = callback(message)
                        if result is not None:
                            await result
                    except BaseException as exc:  # whatever comes out of it, but what ends this task
                        if is_end_of(task, exc):
                            raise
                        self._on_failure(exc)
                else:
                    await anyio.lowlevel.checkpoint()
        except ClosedError:
            return
        finally:
            self._abandon()

    async def run_concurrently(self, callback: Callback[MessageT]) -> None:
        """Call *callback* as :meth:`run_in_turn`, but each message in a task of its own, ``depth`` of them at most."""
        try:
            await _ConcurrentRun(self, callback, self._on_failure).run()
        finally:
            self._abandon()

    async def run_batches(self, take: Callable[[Iterator[MessageT]], None]) -> None:
        """Call *take* with the messages that wait, until the subscription is closed; other tasks run in between.

        It takes them one by one, at least one, so that what it leaves still waits, and is given to it again. Where it
        fails, that costs the message that it took last.
        """
        mailbox, task = self.mailbox, asyncio.current_task()
        try:
            while True:
                await mailbox.wait()
                try:
                    take(self._waiting())
                except BaseException as exc:  # as of a callback
                    if is_end_of(task, exc):
                        raise
                    self._on_failure(exc)
                if mailbox.waiting:
                    await anyio.lowlevel.checkpoint()
        except ClosedError:
            return
        finally:
            self._abandon()

    def _waiting(self) -> Iterator[MessageT]:
        """Yield the messages that wait; each is taken when it is asked for."""
        mailbox = self.mailbox
        take, waiting, senders = mailbox.queue.popleft, mailbox.waiting, mailbox.senders
        while waiting:
            item = take()
            if senders:
                mailbox.admit_senders()
            if type(item) is not Expiring:
                yield item
            elif (message := self._unexpired(item)) is not None:
                yield message

    def _abandon(self) -> None:
        """Note that what called back has ended, so that nobody reads the rest."""
        self._is_abandoned = True
        if self._closed:
            self.mailbox.clear()

    def _unexpired(self, item: Expiring[MessageT]) -> MessageT | None:
        if self._clock.monotonic() < item.expires_at:
            return item.message
        self.expired += 1
        return None


class _ConcurrentRun(Generic[MessageT]):
    """Calls back with the messages of a subscription side by side, as many at a time as it may have queued.

    The task that takes a message handles it, while another one goes on to read. So a lone message, as nearly all are,
    waits for no task to begin; and no task is made for it, as one that has handled a message stands by to read on when
    the next comes. Those that lie there already get their tasks in one go, and begin in their order.
    """

    def __init__(
        self,
        subscription: Subscription[MessageT],
        callback: Callback[MessageT],
        on_failure: Callable[[BaseException], None],
    ) -> None:
        self._subscription = subscription
        self._mailbox = subscription.mailbox
        self._callback = callback
        self._on_failure = on_failure
        self._limit = asyncio.Semaphore(subscription.qos.queue_depth)
        self._tasks = anyio.create_task_group()
        self._standby: asyncio.Future[None] | None = None
        self._has_ended = False

    async def run(self) -> None:
        """Run until the subscription is closed and all is handled."""
        async with self._tasks:
            self._tasks.start_soon(self._read)

    async def _read(self) -> None:
        while True:
            await self._limit.acquire()  # before the message is taken: until then it waits where losses are counted
            is_first = not self._mailbox.queue
            try:
                await self._mailbox.wait()  # here, because each wake-up goes through all that wait
                message = await self._subscription.receive()
            except ClosedError:
                self._has_ended = True
                self._wake_standby()
                return
            if not is_first or self._mailbox.queue:
                self._subscription.unbegun += 1
                self._tasks.start_soon(self._begin, message)
                continue
            if not self._wake_standby():
                self._tasks.start_soon(self._read)
            await self._handle(message)
            if self._has_ended or self._standby is not None:
                return
            self._standby = asyncio.get_running_loop().create_future()
            await self._standby

    async def _begin(self, message: MessageT) -> None:
        self._subscription.unbegun -= 1
        await self._handle(message)

    async def _handle(self, message: MessageT) -> None:
        task = asyncio.current_task()
        try:
            result = self._callback(message)
            if result is not None:
                await result
        except BaseException as exc:  # whatever comes out of it, but what ends this task
            if is_end_of(task, exc):
                raise
            self._on_failure(exc)
        finally:
            self._limit.release()

    def _wake_standby(self) -> bool:
        """Let the task that stands by read on; return whether there was one."""
        standby, self._standby = self._standby, None
        if standby is None or standby.done():  # it was cancelled
            return False
        standby.set_result(None)
        return True


def key_of(message_type: type[MessageT]) -> Callable[[MessageT | Expiring[MessageT]], Hashable] | None:
    """Return what reads the key of a queued message; None where the topic is not keyed."""
    return None if message_type.key_field is None else attrgetter(message_type.key_field)
