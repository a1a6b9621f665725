"""The retained messages: the last one of each topic, for those who subscribe later. No I/O."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import Final, final

from homebot.mqtt.broker.message import BrokerMessage
from homebot.timer_queue import TimerQueue

__all__ = ["RetainedMessages"]

_SWEEP: Final = 64  # removed entries that may stay behind in any case


@final
class RetainedMessages:
    """At most one message per topic, bounded in number and in bytes, numbered in the order they came.

    Args:
        max_messages: Bound in messages.
        max_bytes: Bound in bytes of payloads and topics.
    """

    def __init__(self, max_messages: int, max_bytes: int) -> None:
        self._messages: dict[str, BrokerMessage] = {}
        self._log: list[BrokerMessage | None] = []  # in the order they came; None where one was removed
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

    def keep(self, message: BrokerMessage, now: float) -> bool:
        """Put *message* in place of its topic's last one; an empty payload only removes that.

        Returns:
            False where there is no room, even after all that has expired was removed; the topic then keeps
            what it had.
        """
        if not message.payload:
            self._remove(message.topic)
            return True
        if not self._has_room(message):
            self._remove_expired(now)
            if not self._has_room(message):
                return False
        self._remove(message.topic)
        self._add(message)
        return True

    def get(self, topic: str) -> BrokerMessage | None:
        """The message of *topic*; it may be expired."""
        return self._messages.get(topic)

    def after(self, order: int, most: int) -> tuple[list[BrokerMessage], int]:
        """The messages that came after the one with the number *order*, the oldest first; some may be expired.

        Args:
            order: Where to go on.
            most: How many to look at.

        Returns:
            The messages, and where to go on: at least :attr:`last` where there are no more.
        """
        start = bisect_right(self._orders, order)
        stop = start + most
        found = [message for message in self._log[start:stop] if message is not None]
        return found, self._orders[stop - 1] if stop <= len(self._orders) else self.last

    def _add(self, message: BrokerMessage) -> None:
        self.last += 1
        message.order = self.last
        self._messages[message.topic] = message
        self._log.append(message)
        self._orders.append(self.last)
        self.size += message.size
        if message.expires_at is not None:
            self._expiring.set(message.topic, message.expires_at, None)

    def _has_room(self, message: BrokerMessage) -> bool:
        old = self._messages.get(message.topic)
        count = len(self._messages) + (old is None)
        size = self.size + message.size - (0 if old is None else old.size)
        return count <= self._max_messages and size <= self._max_bytes

    def _remove_expired(self, now: float) -> None:
        while (due := self._expiring.pop(now)) is not None:
            self._remove(due[0])

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
            self._orders = [each.order for each in self._messages.values()]
            self._removed = 0
