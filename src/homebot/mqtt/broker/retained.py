"""Retained messages: the last one of each topic, and their replay to new subscriptions. No I/O."""

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable
from typing import Final, final

from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.mqtt.filter_tree import FilterTree
from homebot.support.timer_queue import TimerQueue
from homebot.support.turn_budget import TurnBudget

_SWEEP: Final = 64  # removed entries that may always remain


@final
class RetainedMessages:
    """One message per topic, bounded in number and bytes, numbered in order of arrival.

    Args:
        max_bytes: Limit in bytes of payloads and topics.
    """

    def __init__(self, max_messages: int, max_bytes: int) -> None:
        self._messages: dict[str, BrokerMessage] = {}
        self._log: list[BrokerMessage | None] = []  # in order of arrival; None if removed
        self._orders: list[int] = []  # of the log
        self._removed = 0
        self._expiring: TimerQueue[str, None] = TimerQueue()  # topics of messages that expire
        self._max_messages = max_messages
        self._max_bytes = max_bytes
        self.size = 0
        self.last = 0
        """The number of the newest message."""

    def __len__(self) -> int:
        return len(self._messages)

    def store(self, message: BrokerMessage, now: float) -> bool:
        """Replace the message of a topic; an empty payload removes it.

        Returns:
            False if there is no room even after removing expired messages; the topic then keeps its last message.
        """
        if not message.payload:
            self._remove(message.topic)
            return True
        if not self._has_room(message):
            while (due := self._expiring.pop(now)) is not None:
                self._remove(due[0])
            if not self._has_room(message):
                return False
        self._remove(message.topic)
        self.last += 1
        message.order = self.last
        self._messages[message.topic] = message
        self._log.append(message)
        self._orders.append(self.last)
        self.size += message.size
        if message.expires_at is not None:
            self._expiring.set(message.topic, message.expires_at, None)
        return True

    def get(self, topic: str) -> BrokerMessage | None:
        """Return the message of *topic*, which may be expired."""
        return self._messages.get(topic)

    def after(self, order: int, most: int) -> tuple[list[BrokerMessage], int]:
        """Return the messages after number *order*, oldest first; some may be expired.

        Returns:
            The messages, and the number to continue from: at least :attr:`last` if there are no more.
        """
        start = bisect_right(self._orders, order)
        stop = start + most
        messages = [message for message in self._log[start:stop] if message is not None]
        return messages, self._orders[stop - 1] if stop <= len(self._orders) else self.last

    def _has_room(self, message: BrokerMessage) -> bool:
        old = self._messages.get(message.topic)
        count = len(self._messages) + (old is None)
        size = self.size + message.size - (0 if old is None else old.size)
        return count <= self._max_messages and size <= self._max_bytes

    def _remove(self, topic: str) -> None:
        message = self._messages.pop(topic, None)
        if message is None:
            return
        if message.expires_at is not None:
            self._expiring.discard(topic)
        self.size -= message.size
        self._log[bisect_left(self._orders, message.order)] = None
        self._removed += 1
        if self._removed > _SWEEP and 2 * self._removed > len(self._log):
            self._log = list(self._messages.values())
            self._orders = [message.order for message in self._messages.values()]
            self._removed = 0


_CHUNK: Final = 100  # filters added, or topics matched with a single filter, before the clock is read
_SMALL_CHUNK: Final = 5  # topics matched with many filters: each may cost a thousand nodes
_WEIGHT: Final = 500  # estimated bytes of a waiting filter

Owed = tuple[BrokerMessage, SessionSubscription]
"""A retained message, and the subscription for it."""


@final
class Replay:
    """The remaining retained messages for one SUBSCRIBE: those retained when it was made, and still retained.

    A message that has replaced one since is left out, because it was forwarded on arrival.
    """

    def __init__(self, retained: RetainedMessages, is_current: Callable[[SessionSubscription], bool]) -> None:
        self._retained = retained
        self._is_current = is_current
        self._until = retained.last
        self._place = 0
        self._exact: deque[SessionSubscription] = deque()
        self._wild: list[SessionSubscription] = []
        self._tree: FilterTree[int, SessionSubscription] = FilterTree()
        self._in_tree = 0
        self._found: deque[Owed] = deque()
        self._only_kept = False
        self.complete = False
        """Whether all its filters were added; before, it has no end."""

    @property
    def size(self) -> int:
        """Estimated bytes while it waits."""
        return _WEIGHT * (len(self._exact) + len(self._wild))

    def add(self, subscription: SessionSubscription) -> None:
        """Add the messages for one more filter."""
        if "+" in subscription.filter or "#" in subscription.filter:
            self._wild.append(subscription)
        else:
            self._exact.append(subscription)

    def leave_out_qos0(self) -> None:
        """Leave out QoS 0 messages for an absent client."""
        self._only_kept = True
        self.complete = True

    def first(self, turn: TurnBudget, now: float) -> Owed | None:
        """Return the next message; None if there is none, or no time in this turn: see :attr:`is_over`."""
        while not self._found:
            if not self.complete or self.is_over or not turn.has_time():
                return None
            self._look(now)
        return self._found[0]

    def popleft(self) -> None:
        """Remove the next message."""
        self._found.popleft()

    @property
    def is_over(self) -> bool:
        """True if there is nothing left."""
        if self._found or self._exact or not self.complete:
            return False
        return not self._wild or self._place >= self._until

    def _look(self, now: float) -> None:
        if self._exact:
            subscription = self._exact.popleft()
            message = self._retained.get(subscription.filter)
            if message is not None:
                self._owe(message, [subscription], now)
            return
        if self._in_tree < len(self._wild):
            some = self._wild[self._in_tree : self._in_tree + _CHUNK]
            for place, added in enumerate(some, self._in_tree):
                self._tree.add(added.levels, place, added)
            self._in_tree += len(some)
            return
        messages, self._place = self._retained.after(self._place, _CHUNK if len(self._wild) == 1 else _SMALL_CHUNK)
        for message in messages:
            branches = self._tree.matching(message.topic.split("/"))
            matched = sorted(item for branch in branches for item in branch.items())
            self._owe(message, [subscription for _, subscription in matched], now)

    def _owe(self, message: BrokerMessage, subscriptions: list[SessionSubscription], now: float) -> None:
        if message.order > self._until or message.expired(now):
            return
        for subscription in subscriptions:
            if self._only_kept and not min(message.qos, subscription.qos):
                continue
            if self._is_current(subscription):
                self._found.append((message, subscription))
