"""Subscription to a topic."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final, Generic, TypeAlias, TypeVar, final

import anyio
import anyio.lowlevel

from homebot.clock import Clock
from homebot.errors import ClosedError
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.mailbox import TURN, BoundedQueue, Mailbox
from homebot.graph.qos import QoSProfile
from homebot.messages.message import Message
from homebot.support.isolation import is_end_of

if TYPE_CHECKING:
    from homebot.graph.qos_events import (
        EventWatcher,
        LivelinessChangedStatus,
        MatchedStatus,
        RequestedDeadlineMissedStatus,
        TopicEnd,
    )

MessageT = TypeVar("MessageT", bound=Message)
StatusT = TypeVar("StatusT", "MatchedStatus", "RequestedDeadlineMissedStatus", "LivelinessChangedStatus")
T = TypeVar("T")

Callback: TypeAlias = Callable[[MessageT], Awaitable[None] | None]


@final
@dataclass(frozen=True, slots=True)
class Expiring(Generic[T]):
    """A queued message with a lifespan, or for a reader that asks for its sender."""

    message: T
    expires_at: float
    sender: GraphEntity | None = None

    def __getattr__(self, name: str) -> object:
        """Return a field of the message, so that keys can be read as if from the message itself."""
        return getattr(self.message, name)


OTHERS: Final = "others"
"""As `from_node`: every node but the subscribing one (ROS: ``ignore_local_publications``)."""


class Subscription(GraphEntity, Generic[MessageT]):
    """Reads messages of one type from one topic: ``async for message in subscription``, or a callback.

    Attributes:
        from_node: Full name of the only publishing node that it receives from; empty for all nodes, :data:`OTHERS` for
            all but its own.
        names_sender: Whether it records the sender of each message.
        sender: The publisher of the message that was taken last, until the next one is; None unless recorded. It is
            closed once the node, or the client outside, that published is gone.
        expired: The number of messages not delivered because their lifespan had passed.
        unbegun: The number of received messages whose task has not begun.
        slowest: The longest run of its sequential callback in seconds, including waits; None if not measured.
    """

    def __init__(
        self,
        topic: str,
        message_type: type[MessageT],
        node: str,
        qos: QoSProfile,
        clock: Clock,
        on_close: Callable[[Any], None],
        on_failure: Callable[[BaseException], None],
        from_node: str = "",
        queue: BoundedQueue[MessageT | Expiring[MessageT]] | None = None,
        *,
        names_sender: bool = False,
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_subscription` instead."""
        super().__init__(EndpointInfo(EntityKind.SUBSCRIPTION, node, topic, message_type.ros_type, qos), on_close)
        self.qos = qos
        self.from_node = from_node
        self.names_sender = names_sender
        self.sender: GraphEntity | None = None
        self.incompatible_qos_count = 0
        self.expired = 0
        self.unbegun = 0
        self.slowest: float | None = None
        self._is_keyed = message_type.key_field is not None
        self.on_failure = on_failure
        self.watchers: tuple[EventWatcher[Any], ...] = ()
        self.matched_ends: Callable[[], Sequence[TopicEnd]] = tuple
        """Return the matched publishers; set by the topic while it is connected."""
        self._is_abandoned = False  # the callback loop has ended, and nothing will read the remaining messages
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
    def losses(self) -> int:
        """Messages that were lost or expired in the queue; 0 if only the newest one (of each key) matters."""
        return self.lost + self.expired if self.qos.queue_depth > 1 and not self._is_keyed else 0

    def take(self) -> MessageT | None:
        """Remove and return the oldest queued message, or None."""
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

    def on_event(self, status: type[StatusT], callback: Callable[[StatusT], None]) -> None:
        """Call back with each new *status*, a class of :mod:`homebot.graph.qos_events`; existing matches count."""
        self.watchers += (status.watch(self, callback),)

    def __aiter__(self) -> Subscription[MessageT]:
        return self

    async def __anext__(self) -> MessageT:
        try:
            return await self.receive()
        except ClosedError:
            raise StopAsyncIteration from None

    def close(self) -> None:
        """Leave the topic and end the iteration after the last queued message. Idempotent."""
        if not self.is_closed:
            # The callback refers to the subscription: the cycle would keep all unread messages in memory.
            for watcher in self.watchers:
                watcher.close()
            super().close()
            self.mailbox.close()
            if self._is_abandoned:
                self.mailbox.clear()

    async def run_in_turn(self, callback: Callback[MessageT]) -> None:
        """Call *callback* with one message at a time until the subscription is closed.

        A failing callback costs only its message.
        """
        mailbox = self.mailbox
        pop, waiting, senders = mailbox.queue.popleft, mailbox.waiting, mailbox.senders
        task = asyncio.current_task()
        try:
            while True:
                await mailbox.wait()
                call = callback if self.slowest is None else partial(self._time, callback)
                for _ in range(TURN):
                    if not waiting:
                        break
                    item = pop()
                    if senders:
                        mailbox.admit_senders()
                    if type(item) is Expiring:
                        message = self._unexpired(item)
                        if message is None:
                            continue
                    else:
                        message = item
                    try:
                        result = call(message)
                        if result is not None:
                            await result
                    except BaseException as exc:  # every failure but the end of this task
                        if is_end_of(task, exc):
                            raise
                        self.on_failure(exc)
                else:
                    await anyio.lowlevel.checkpoint()
        except ClosedError:
            return
        finally:
            self._abandon()

    async def _time(self, callback: Callback[MessageT], message: MessageT) -> None:
        began = self._clock.monotonic()
        result = callback(message)
        if result is not None:
            await result
        if self.slowest is not None:
            self.slowest = max(self.slowest, self._clock.monotonic() - began)

    async def run_concurrently(self, callback: Callback[MessageT]) -> None:
        """Call *callback* in one task for each message, at most ``depth`` of them at a time."""
        limit = asyncio.Semaphore(self.qos.queue_depth)
        try:
            async with anyio.create_task_group() as tasks:
                with suppress(ClosedError):
                    while True:
                        await limit.acquire()  # first, so that messages wait in the queue that counts losses
                        message = await self.receive()
                        self.unbegun += 1
                        tasks.start_soon(self._handle, callback, limit, message)
        finally:
            self._abandon()

    async def _handle(self, callback: Callback[MessageT], limit: asyncio.Semaphore, message: MessageT) -> None:
        self.unbegun -= 1
        task = asyncio.current_task()
        try:
            result = callback(message)
            if result is not None:
                await result
        except BaseException as exc:  # every failure but the end of this task
            if is_end_of(task, exc):
                raise
            self.on_failure(exc)
        finally:
            limit.release()

    async def run_batches(self, handle: Callable[[Iterator[MessageT]], None]) -> None:
        """Call *handle* with an iterator over the queued messages, until the subscription is closed.

        *handle* consumes at least one message; unread ones stay queued for the next call. A failure costs only the
        message that was read last.
        """
        mailbox, task = self.mailbox, asyncio.current_task()
        try:
            while True:
                await mailbox.wait()
                try:
                    handle(self._waiting())
                except BaseException as exc:  # as of a callback
                    if is_end_of(task, exc):
                        raise
                    self.on_failure(exc)
                if mailbox.waiting:
                    await anyio.lowlevel.checkpoint()
        except ClosedError:
            return
        finally:
            self._abandon()

    def _waiting(self) -> Iterator[MessageT]:
        """Yield the queued messages, each removed when it is requested."""
        mailbox = self.mailbox
        pop, waiting, senders = mailbox.queue.popleft, mailbox.waiting, mailbox.senders
        while waiting:
            item = pop()
            if senders:
                mailbox.admit_senders()
            if type(item) is not Expiring:
                yield item
            elif (message := self._unexpired(item)) is not None:
                yield message

    def _abandon(self) -> None:
        """Mark the callback loop as ended; a closed subscription drops its unread messages."""
        self._is_abandoned = True
        if self.is_closed:
            self.mailbox.clear()

    def put(self, item: MessageT | Expiring[MessageT], sender: GraphEntity) -> None:
        """Queue a message of *sender*; called by it."""
        if self.names_sender:
            until = item.expires_at if isinstance(item, Expiring) else math.inf
            item = Expiring(item.message if isinstance(item, Expiring) else item, until, sender)
        self.mailbox.put(item)

    def _unexpired(self, item: Expiring[MessageT]) -> MessageT | None:
        self.sender = item.sender
        if self._clock.monotonic() < item.expires_at:
            return item.message
        self.expired += 1
        return None


def key_of(message_type: type[MessageT]) -> Callable[[MessageT | Expiring[MessageT]], Hashable] | None:
    """Return the key function for queued messages, or None without a key field."""
    return None if message_type.key_field is None else attrgetter(message_type.key_field)
