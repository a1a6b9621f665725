"""The messages waiting for one client. No I/O."""

from collections import deque
from collections.abc import Callable, Iterator
from enum import IntEnum
from typing import Final, NamedTuple, final

from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.retained import Replay


class DeliveryResult(IntEnum):
    """The result for a message and one session: accepted; accepted, but slow down; refused."""

    TAKEN = 0
    SLOW = 1
    REFUSED = 2


TAKEN: Final = DeliveryResult.TAKEN  # by these names they are found twice as fast, for every receiver of every message
SLOW: Final = DeliveryResult.SLOW
REFUSED: Final = DeliveryResult.REFUSED


class QueuedMessage(NamedTuple):
    """A message for one client.

    Attributes:
        qos: QoS of the delivery, 0 to 2.
        identifiers: The subscription identifiers of all subscriptions that matched.
    """

    message: BrokerMessage
    qos: int
    retain: bool
    identifiers: tuple[int, ...] = ()
    share: tuple[str, str] | None = None


@final
class MessageQueue:
    """A first-in-first-out queue that tracks its size and leaves overflow to its owner.

    The retained messages for new subscriptions are one entry, a :class:`Replay`, which finds them when its turn comes.

    Attributes:
        messages: The waiting messages, the next one first; read-only.

    Args:
        max_bytes: Limit in bytes of payload and topic; a single larger message still fits into an empty queue.
    """

    __slots__ = (
        "_count",
        "_high_bytes",
        "_high_messages",
        "_max_bytes",
        "_max_messages",
        "_qos0",
        "_replays",
        "messages",
        "size",
    )

    def __init__(self, max_messages: int, max_bytes: int, count: Callable[[int], None]) -> None:
        self._count = count
        self.messages: deque[QueuedMessage | Replay] = deque()
        self._replays: deque[tuple[Replay, int]] = deque()  # with their counted sizes
        self.size = 0
        self._qos0 = 0
        self._max_messages = max_messages
        self._max_bytes = max_bytes
        self._high_messages = _three_quarters(max_messages)
        self._high_bytes = _three_quarters(max_bytes)

    def __len__(self) -> int:
        return len(self.messages)

    @property
    def full(self) -> bool:
        """True if another message would exceed the limit."""
        return len(self.messages) >= self._max_messages or self.size >= self._max_bytes

    @property
    def high(self) -> bool:
        """True from three quarters of the limit, to slow down publishers."""
        return len(self.messages) >= self._high_messages or self.size >= self._high_bytes

    @property
    def low(self) -> bool:
        """True if half of the limit is free again."""
        return 2 * len(self.messages) <= self._max_messages and 2 * self.size <= self._max_bytes

    @property
    def holds_qos0(self) -> bool:
        """True if QoS 0 messages are waiting, which later ones must not overtake."""
        return self._qos0 > 0

    def offer(self, queued: QueuedMessage) -> DeliveryResult:
        """Append within the limit; return SLOW if the queue is :attr:`high` now, REFUSED if it is full."""
        count = len(self.messages)
        if count >= self._max_messages or self.size >= self._max_bytes:
            return REFUSED
        self.append(queued)
        return SLOW if count + 1 >= self._high_messages or self.size >= self._high_bytes else TAKEN

    def append(self, queued: QueuedMessage) -> None:
        """Append without a limit."""
        self.messages.append(queued)
        message, qos, _, _, _ = queued
        self.size += message.size
        if not qos:
            self._qos0 += 1
        message.hold(self._count)

    def append_replay(self, replay: Replay) -> None:
        """Append the retained messages for new subscriptions without a limit."""
        self.messages.append(replay)
        self._replays.append((replay, replay.size))
        self.size += replay.size
        self._count(replay.size)
        self._qos0 += 1

    def count_again(self, replay: Replay) -> None:
        """Update the size of *replay*, which has more filters now, if it is still the last one in the queue."""
        if self._replays and self._replays[-1][0] is replay:
            size = self._replays.pop()[1]
            self._replays.append((replay, replay.size))
            self.size += replay.size - size
            self._count(replay.size - size)

    def popleft(self) -> QueuedMessage | Replay:
        """Remove and return the first message."""
        first = self.messages.popleft()
        if type(first) is Replay:
            size = self._replays.popleft()[1]
            self.size -= size
            self._count(-size)
            self._qos0 -= 1
        else:
            message, qos, _, _, _ = first
            self.size -= message.size
            if not qos:
                self._qos0 -= 1
            message.release(self._count)
        return first

    def drop_qos0(self) -> None:
        """Drop the QoS 0 messages of a client that has left."""
        if self._qos0:
            for _ in range(len(self.messages)):
                first = self.popleft()
                if isinstance(first, Replay):
                    first.leave_out_qos0()
                    self.append_replay(first)
                elif first.qos:
                    self.append(first)

    def clear(self) -> Iterator[QueuedMessage]:
        """Remove and yield the messages, without unfinished replays."""
        while self.messages:
            first = self.popleft()
            if not isinstance(first, Replay):
                yield first


def _three_quarters(bound: int) -> int:
    return -(-3 * bound // 4)
