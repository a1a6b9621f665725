"""The messages that one client published within the last second, for readers that come a moment late.

They are kept as the client sent them: most streams are read by nobody, and need not be checked.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple, final

from homebot.bridges.rosbridge.protocol import PublishOperation
from homebot.clock import Clock
from homebot.messages.message import Message

__all__ = ["RecentMessages", "TopicHistory"]

_SECONDS: Final = 1.0
_MOST: Final = 10
"""Messages of one topic for a late reader."""

_CHARACTERS: Final = 1_048_576
"""Of all frames of a client together; the newest one is kept at any size."""


class _Kept(NamedTuple):
    at: float
    size: int
    op: PublishOperation


@final
class RecentMessages:
    """Publish operations of one client, oldest first.

    Args:
        clock: Tells their age.
    """

    def __init__(self, clock: Clock) -> None:
        self._now = clock.monotonic
        self._kept: deque[_Kept] = deque()
        self._size = 0

    def add(self, op: PublishOperation, size: int) -> None:
        """Keep *op*, which came in a frame of *size* characters; drop what is too old or too much."""
        now = self._now()
        self._kept.append(_Kept(now, size, op))
        self._size += size
        oldest = now - _SECONDS
        while len(self._kept) > 1 and (self._kept[0].at <= oldest or self._size > _CHARACTERS):
            self._size -= self._kept.popleft().size

    def of_topic(self, topic: str) -> list[PublishOperation]:
        """Return those of *topic*, oldest first."""
        oldest = self._now() - _SECONDS
        return [one.op for one in self._kept if one.op.topic == topic and one.at > oldest][-_MOST:]


@final
class TopicHistory:
    """History of a publisher on one topic: the recent messages that can be read.

    Args:
        topic: Name of the topic, as the client writes it.
        recent: The messages of the client.
        read: Returns the message of an operation; None where there is none.
        clock: Tells when the next message is due.
    """

    def __init__(
        self, topic: str, recent: RecentMessages, read: Callable[[PublishOperation], Message | None], clock: Clock
    ) -> None:
        self._topic = topic
        self._recent = recent
        self._read = read
        self._now = clock.monotonic
        self._checked_at = -math.inf

    def is_due(self) -> bool:
        """Return whether to check a message that nobody reads all the same, so that its client learns of mistakes."""
        if (now := self._now()) < self._checked_at + _SECONDS:
            return False
        self._checked_at = now
        return True

    def append(self, _item: object) -> None:
        """Do nothing: the operation has been kept already."""

    def __iter__(self) -> Iterator[Message]:
        messages = map(self._read, self._recent.of_topic(self._topic))
        return (message for message in messages if message is not None)
