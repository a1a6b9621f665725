"""The last texts of one part, for listeners that come later. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from homebot.devices import RawMessage

__all__ = ["PartTexts", "missed"]

_KEPT = 10
_KEPT_PAYLOAD = 4096
_MOMENT = 5.0
"""Seconds for which an event is told to who comes to listen: the first makes its device known, and is heard late."""


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
