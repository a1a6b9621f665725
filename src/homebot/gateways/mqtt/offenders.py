"""Who breaks the rules again and again, and for how long he is therefore not listened to. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass, field

__all__ = ["Offender", "Offenders"]

TOLERATED = 5
"""Offences within :data:`WINDOW` that lead to quarantine."""

WINDOW = 600.0
FIRST_TERM = 600.0
LONGEST_TERM = 86_400.0
MAX_OFFENDERS = 1000


@dataclass(slots=True)
class Offender:
    """Somebody who broke a rule.

    Attributes:
        name: Who (MQTT: the topic).
        why: The last rule he broke, in words.
        offences: How often he broke one.
        terms: How often he was quarantined.
        since: When the last quarantine began, in seconds of the clock that offences are told with.
        until: When it ends or ended.
        recent: When he broke the last few rules.
    """

    name: str
    why: str = ""
    offences: int = 0
    terms: int = 0
    since: float = 0.0
    until: float = 0.0
    recent: deque[float] = field(default_factory=lambda: deque(maxlen=TOLERATED))


class Offenders:
    """The books on offenders: of 1,000 at most, of whom the one who was quiet the longest is forgotten first.

    Attributes:
        forgotten: How many were forgotten for want of room.
    """

    def __init__(self, max_offenders: int = MAX_OFFENDERS) -> None:
        self.forgotten = 0
        self._max_offenders = max_offenders
        self._books: OrderedDict[str, Offender] = OrderedDict()
        self._confined: dict[str, Offender] = {}

    def offend(self, name: str, why: str, now: float) -> Offender | None:
        """Book an offence; return the offender if he is quarantined for it, five in ten minutes being enough.

        The first term is ten minutes, and each is twice as long as the one before, to a day at most.
        """
        offender = self._books.setdefault(name, Offender(name))
        self._books.move_to_end(name)
        offender.why = why
        offender.offences += 1
        offender.recent.append(now)
        if len(self._books) > self._max_offenders:
            forgotten, _ = self._books.popitem(last=False)
            self._confined.pop(forgotten, None)
            self.forgotten += 1
        if len(offender.recent) < TOLERATED or now - offender.recent[0] > WINDOW:
            return None
        offender.recent.clear()
        offender.since = now
        offender.until = now + min(FIRST_TERM * 2**offender.terms, LONGEST_TERM)
        offender.terms = min(offender.terms + 1, 16)
        self._confined[name] = offender
        return offender

    def is_confined(self, name: str) -> bool:
        """Whether *name* is quarantined."""
        return name in self._confined

    def release(self, name: str) -> Offender | None:
        """End the quarantine of *name*; return the offender if there was one."""
        return self._confined.pop(name, None)

    def confined(self) -> tuple[Offender, ...]:
        """Return who is quarantined, the longest one first."""
        return tuple(self._confined.values())
