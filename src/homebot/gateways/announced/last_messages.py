"""The last messages of devices, kept for whoever comes later. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from homebot.devices import RawMessage
from homebot.messages import Time

__all__ = ["CachedMessage", "LastMessageCache", "PartTexts", "missed"]

MAX_TOTAL = 32 * 1024 * 1024
MAX_EACH = 64 * 1024

_KEPT = 10
_KEPT_PAYLOAD = 4096
_MOMENT = 5.0
"""Seconds for which an event is told to who comes to listen: the first makes its device known, and is heard late."""


class CachedMessage(NamedTuple):
    """The last message on a topic.

    Attributes:
        payload: The bytes.
        retained: Whether the broker had kept it from before.
        at: When it came.
        heard_at: The same on the monotonic clock.
    """

    payload: bytes
    retained: bool
    at: Time
    heard_at: float


class LastMessageCache:
    """Messages by topic, 32 MiB at most; the one that was replaced the longest ago goes first.

    A longer payload than 64 KiB is not kept.
    """

    def __init__(self, max_total: int = MAX_TOTAL, max_each: int = MAX_EACH) -> None:
        self._max_total = max_total
        self._max_each = max_each
        self._kept: OrderedDict[str, CachedMessage] = OrderedDict()
        self._total = 0

    def keep(self, topic: str, word: CachedMessage) -> None:
        """Remember *word* as the last one on *topic*."""
        self.forget(topic)
        if len(word.payload) > self._max_each:
            return
        self._kept[topic] = word
        self._total += len(word.payload) + len(topic)
        while self._total > self._max_total:
            oldest, lost = self._kept.popitem(last=False)
            self._total -= len(lost.payload) + len(oldest)

    def get(self, topic: str) -> CachedMessage | None:
        """Return the last word on *topic*, or None."""
        return self._kept.get(topic)

    def forget(self, topic: str) -> None:
        """Remember nothing of *topic*."""
        word = self._kept.pop(topic, None)
        if word is not None:
            self._total -= len(word.payload) + len(topic)


@dataclass(slots=True, eq=False)
class PartTexts:
    """The last texts of one part of a device.

    Attributes:
        kept: Its last 10 states as text, of at most 4 KiB, and when each came, for a listener that comes later.
        events: Likewise of texts that tell what happened; they are good for a moment only.
    """

    kept: tuple[tuple[float, RawMessage], ...] = field(default=(), init=False)
    events: tuple[tuple[float, RawMessage], ...] = field(default=(), init=False)

    def keep(self, message: RawMessage, now: float, *, is_event: bool) -> None:
        """Remember a text that came at *now* on the monotonic clock, unless it is long."""
        if len(message.payload) > _KEPT_PAYLOAD:
            return
        if is_event:
            self.events = (*self.events[1 - _KEPT :], (now, message))
        else:
            self.kept = (*self.kept[1 - _KEPT :], (now, message))

    def missed_by(self, since: float, now: float) -> tuple[RawMessage, ...]:
        """Return the kept texts that a listener wants that was there from *since* on, on the monotonic clock.

        What was kept from before is among them where it is still the part's last text.
        """
        recent = missed(self.events, max(since, now - _MOMENT))
        if not recent:
            return missed(self.kept, since)
        wanted = {id(one) for one in (*recent, *missed(self.kept, since))}
        told = sorted((*self.kept, *self.events), key=lambda one: one[0])
        return tuple(one for _, one in told if id(one) in wanted)


def missed(kept: Sequence[tuple[float, RawMessage]], since: float) -> tuple[RawMessage, ...]:
    """Return those of the *kept* messages that came from *since* on, and the last where it was retained."""
    last = kept[-1][1] if kept else None
    return tuple(one for came, one in kept if came >= since or (one is last and one.retained))
