"""Publisher of a topic."""

import math
from collections import deque
from collections.abc import Callable, Hashable, Iterator
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Generic, NoReturn, Protocol, TypeVar

from homebot.clock import Clock
from homebot.errors import ClosedError, TypeMismatchError
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.mailbox import KeyedQueue, Mailbox, keyed_queue
from homebot.graph.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from homebot.graph.subscription import Expiring, Subscription
from homebot.messages.message import Message

if TYPE_CHECKING:
    from homebot.graph.qos_events import (
        EventWatcher,
        LivelinessLostStatus,
        MatchedStatus,
        OfferedDeadlineMissedStatus,
    )

MessageT = TypeVar("MessageT", bound=Message)
StatusT = TypeVar("StatusT", "MatchedStatus", "OfferedDeadlineMissedStatus", "LivelinessLostStatus")

_WATCHERS = attrgetter("watchers")


class History(Protocol[MessageT]):
    """The messages that a publisher keeps for late joiners; iterates from the oldest."""

    def append(self, item: MessageT | Expiring[MessageT], /) -> None:
        """Add *item* at the end."""
        ...

    def __iter__(self) -> Iterator[MessageT | Expiring[MessageT]]: ...


class Publisher(GraphEntity, Generic[MessageT]):
    """Publishes messages of one type on one topic, in order, without blocking."""

    def __init__(
        self,
        topic: str,
        message_type: type[MessageT],
        node: str,
        qos: QoSProfile,
        clock: Clock,
        on_close: Callable[[Any], None],
        on_failure: Callable[[BaseException], None],
        history: History[MessageT] | None = None,
    ) -> None:
        """Use :meth:`homebot.graph.Node.create_publisher` instead."""
        super().__init__(EndpointInfo(EntityKind.PUBLISHER, node, topic, message_type.ros_type, qos), on_close)
        self.qos = qos
        self.subscription_count = 0
        self.incompatible_qos_count = 0
        self.published = 0
        self._message_type = message_type
        self._clock = clock
        self._subscriptions: tuple[Subscription[MessageT], ...] = ()
        self._mailboxes: tuple[Mailbox[MessageT | Expiring[MessageT]], ...] = ()
        self._history = _history(message_type, qos) if history is None else history
        self._is_watched = bool(qos.lifespan or qos.deadline or qos.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC)
        self._is_plain = not self._is_watched
        self.on_failure = on_failure
        self.watchers: tuple[EventWatcher[Any], ...] = ()
        self._asserted_at = -math.inf
        self._is_keyed = message_type.key_field is not None

    @property
    def topic_name(self) -> str:
        """Full name of the topic."""
        return self.info.name

    def reaches(self, node: str) -> bool:
        """Return whether the node with the full name *node* has a matched subscription."""
        for subscription in self._subscriptions:  # noqa: SIM110 - faster than a generator
            if subscription.info.node == node:
                return True
        return False

    @property
    def is_full(self) -> bool:
        """True if a RELIABLE subscription has no room, so that :meth:`send` would wait; never on a keyed topic."""
        for subscription in self._subscriptions:  # as in reaches
            if (
                len(subscription.mailbox.queue) >= subscription.mailbox.depth
                and subscription.qos.reliability is ReliabilityPolicy.RELIABLE
            ):
                return True
        return False

    def publish(self, message: MessageT) -> None:
        """Queue *message* for every matched subscription; never blocks.

        A full queue drops its oldest message and counts the loss.

        Raises:
            TypeMismatchError: *message* is not exactly of the topic's type.
            ClosedError: The publisher was closed.
        """
        if type(message) is not self._message_type:
            self._reject(message)
        self.published += 1
        if not self._is_plain:
            self._publish_watched(message)
            return
        if self._history is not None:
            self._history.append(message)
        # Inlined Mailbox.put: these loops are the cost of a delivery.
        if self._is_keyed:  # its queues keep their own bounds
            for mailbox in self._mailboxes:
                mailbox.queue.append(message)
                if mailbox.waiter is not None:
                    mailbox.wake()
            return
        for mailbox in self._mailboxes:
            queue = mailbox.queue
            if len(queue) >= mailbox.depth:
                mailbox.drop_oldest()
            queue.append(message)
            if mailbox.waiter is not None:
                mailbox.wake()

    async def send(self, message: MessageT) -> bool:
        """Publish *message* once every RELIABLE subscription has room for it (keyed: room for its key).

        Waits indefinitely until the reader reads or either end is closed. The order of several waiting senders is
        undefined.

        Returns:
            Whether it waited; subscriptions may have changed meanwhile.

        Raises:
            TypeMismatchError, ClosedError: As :meth:`publish`.
        """
        if type(message) is not self._message_type:
            self._reject(message)
        has_waited = False
        while (full := self._first_full(message)) is not None:
            has_waited = True
            await full.wait_for_change()
        self.publish(message)
        return has_waited

    def dispose(self, key: Hashable) -> None:
        """Drop the history of *key*, so that a keyed TRANSIENT_LOCAL topic stays bounded."""
        if isinstance(self._history, KeyedQueue):
            self._history.discard(key)

    def close(self) -> None:
        """Leave the topic and drop the history. Idempotent."""
        if not self.is_closed:
            self._is_plain = False
            self._history = None
            mailboxes = self._mailboxes
            for watcher in self.watchers:
                watcher.close()
            super().close()
            for mailbox in mailboxes:
                mailbox.admit_senders()

    def on_event(self, status: type[StatusT], callback: Callable[[StatusT], None]) -> None:
        """Call back with each new *status*, a class of :mod:`homebot.graph.qos_events`; existing matches count."""
        self.watchers += (status.watch(self, callback),)

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive, as a message does; only MANUAL_BY_TOPIC needs it.

        Raises:
            ClosedError: The publisher was closed.
        """
        self._check_open()
        self._record_activity(is_message=False)

    def is_lively(self) -> bool:
        """Return whether the publisher asserted its liveliness within its lease."""
        lease = self.qos.liveliness_lease_duration or math.inf
        return self._clock.monotonic() - self._asserted_at < lease

    def matched_ends(self) -> tuple[Subscription[MessageT], ...]:
        """Return the matched subscriptions."""
        return self._subscriptions

    def connect(self, subscriptions: tuple[Subscription[MessageT], ...]) -> None:
        """Publish to *subscriptions* from now on; called by the topic."""
        before, self._subscriptions = self._subscriptions, subscriptions
        self._mailboxes = tuple([subscription.mailbox for subscription in subscriptions])
        self.subscription_count = len(subscriptions)
        are_asked = [subscription for subscription in subscriptions if subscription.names_sender]
        self._is_plain = not (self._is_watched or are_asked or self.is_closed)
        if self.watchers or [subscription for subscription in (*before, *subscriptions) if subscription.watchers]:
            for subscription in before:
                if subscription not in subscriptions:
                    self._report_match(subscription, -1)
            for subscription in subscriptions:
                if subscription not in before:
                    self._report_match(subscription, 1)

    def _report_match(self, subscription: Subscription[MessageT], change: int) -> None:
        for watcher in self.watchers:
            watcher.on_match(subscription, change)
        for watcher in subscription.watchers:
            watcher.on_match(self, change)

    def replay(self, subscription: Subscription[MessageT]) -> None:
        """Queue the history for *subscription*, oldest first; called by the topic."""
        mailbox = subscription.mailbox
        lost = mailbox.lost
        for item in self._kept():
            subscription.put(item, self)
        mailbox.lost = lost  # a queue shorter than the history does not count as loss

    def _publish_watched(self, message: MessageT) -> None:
        """Publish *message* with a lifespan, a deadline, a liveliness assertion, or readers of its sender."""
        self._check_open()
        lifespan = self.qos.lifespan
        item = Expiring(message, self._clock.monotonic() + lifespan) if lifespan else message
        if self._history is not None:
            self._history.append(item)
        for subscription in self._subscriptions:
            subscription.put(item, self)
        self._record_activity(is_message=True)

    def _record_activity(self, *, is_message: bool) -> None:
        self._asserted_at = self._clock.monotonic()
        for watchers in (self.watchers, *map(_WATCHERS, self._subscriptions)):
            for watcher in watchers:
                watcher.on_activity(self, is_message=is_message)

    def _check_open(self) -> None:
        if self.is_closed:
            raise ClosedError(f"the publisher of {self.info.node} on {self.info.name} is closed")

    def _kept(self) -> Iterator[MessageT | Expiring[MessageT]]:
        now = self._clock.monotonic()
        for item in self._history or ():
            if not isinstance(item, Expiring) or item.expires_at > now:
                yield item

    def _first_full(self, message: MessageT) -> Mailbox[MessageT | Expiring[MessageT]] | None:
        for subscription in self._subscriptions:
            mailbox = subscription.mailbox
            if subscription.qos.reliability is ReliabilityPolicy.RELIABLE and not mailbox.has_room_for(message):
                return mailbox
        return None

    def _reject(self, message: object) -> NoReturn:
        raise TypeMismatchError(
            f"{self.info.node} published a {type(message).__name__} on {self.info.name}, "
            f"which carries {self.info.ros_type}"
        )


def _history(message_type: type[MessageT], qos: QoSProfile) -> History[MessageT] | None:
    if qos.durability is DurabilityPolicy.VOLATILE:
        return None
    if message_type.key_field is None:
        return deque(maxlen=qos.queue_depth)
    read_key = attrgetter(f"message.{message_type.key_field}" if qos.lifespan else message_type.key_field)
    return keyed_queue(qos.queue_depth, read_key)
