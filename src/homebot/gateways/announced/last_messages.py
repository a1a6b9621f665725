"""The last message on each topic, kept for parts that are announced later. Pure."""

from collections import OrderedDict
from typing import NamedTuple

from homebot.messages import Time

MAX_TOTAL = 32 * 1024 * 1024
MAX_EACH = 64 * 1024


class CachedMessage(NamedTuple):
    """The last message on a topic."""

    payload: bytes
    retained: bool
    at: Time
    heard_at: float


class LastMessageCache:
    """The last message of each topic: 32 MiB at most, of which the oldest goes first; none with over 64 KiB."""

    def __init__(self, max_total: int = MAX_TOTAL, max_each: int = MAX_EACH) -> None:
        self._max_total = max_total
        self._max_each = max_each
        self._kept: OrderedDict[str, CachedMessage] = OrderedDict()
        self._total = 0

    def put(self, topic: str, payload: bytes, at: Time, heard_at: float, *, retained: bool) -> None:
        """Store the last message on *topic*; see :class:`CachedMessage`."""
        kept, length = self._kept, len(payload)
        before = kept.pop(topic, None)
        if length > self._max_each:
            self._total -= 0 if before is None else len(before.payload) + len(topic)
            return
        kept[topic] = CachedMessage(payload, retained, at, heard_at)
        self._total += length + len(topic) if before is None else length - len(before.payload)
        while self._total > self._max_total:
            oldest, lost = kept.popitem(last=False)
            self._total -= len(lost.payload) + len(oldest)

    def get(self, topic: str) -> CachedMessage | None:
        """Return the last message on *topic*, or None."""
        return self._kept.get(topic)
