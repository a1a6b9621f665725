"""The messages that one client published within the last second, for readers that come a moment late.

They are kept as the client sent them: most streams are read by nobody, and need not be checked.
"""

from __future__ import annotations

from collections import deque
from typing import Final, NamedTuple, TypeAlias, final

from homebot.bridges.rosbridge.protocol import PublishOperation
from homebot.clock import Clock

__all__ = ["RecentMessages", "SentMessage"]

SentMessage: TypeAlias = "PublishOperation | str"
"""A message as its client sent it: the operation, or the text of its frame."""

_SECONDS: Final = 1.0
_MOST: Final = 10
"""Messages of one topic for a late reader."""

_CHARACTERS: Final = 1_048_576
"""Of all frames of a client together; the newest one is kept at any size."""


class _Kept(NamedTuple):
    at: float
    size: int
    topic: str
    message: SentMessage


@final
class RecentMessages:
    """Messages of one client, oldest first.

    Args:
        clock: Tells their age.
    """

    def __init__(self, clock: Clock) -> None:
        self._now = clock.monotonic
        self._kept: deque[_Kept] = deque()
        self._size = 0

    def add(self, topic: str, message: SentMessage, size: int) -> None:
        """Keep *message*, which came in a frame of *size* characters; drop what is too old or too much."""
        now = self._now()
        self._kept.append(_Kept(now, size, topic, message))
        self._size += size
        oldest = now - _SECONDS
        while len(self._kept) > 1 and (self._kept[0].at <= oldest or self._size > _CHARACTERS):
            self._size -= self._kept.popleft().size

    def of_topic(self, topic: str) -> list[SentMessage]:
        """Return those of *topic*, oldest first."""
        oldest = self._now() - _SECONDS
        return [one.message for one in self._kept if one.topic == topic and one.at > oldest][-_MOST:]
