"""Events of a house, in order."""

from collections import deque
from itertools import islice
from typing import Literal, NamedTuple

from homebot.house.rooms import DAY

Verb = Literal["says", "told", "switch", "power", "enters", "sleeps"]


class Event(NamedTuple):
    """An event.

    Attributes:
        at: Seconds since the first midnight.
        who: The name of the device or person.
        verb: A device ``says`` a report, is ``told`` a command, is operated by hand (``switch``), or its ``power`` goes
            ``off`` or ``on``; a person ``enters`` a room or ``sleeps`` there.
        what: The report, command, state or room.
        command: The id of the command, if it had one.
    """

    at: float
    who: str
    verb: Verb
    what: str
    command: str = ""

    def __str__(self) -> str:
        milliseconds = round(self.at * 1000)
        days, rest = divmod(milliseconds, int(DAY) * 1000)
        hours, rest = divmod(rest, 3_600_000)
        minutes, rest = divmod(rest, 60_000)
        what = self.what if self.what.isprintable() else ascii(self.what)  # one line per event
        return f"{days} {hours:02}:{minutes:02}:{rest // 1000:02}.{rest % 1000:03} {self.who} {self.verb} {what}"


class WorldLog:
    """The newest events; when it is full, the oldest is dropped.

    Args:
        capacity: Events kept, at least 1.

    Attributes:
        count: Total number of events.
    """

    def __init__(self, capacity: int = 100_000) -> None:
        self._events: deque[Event] = deque(maxlen=capacity)
        self.count = 0

    @property
    def dropped(self) -> int:
        """Number of events that are no longer kept."""
        return self.count - len(self._events)

    def add(self, event: Event) -> None:
        """Add *event*."""
        self._events.append(event)
        self.count += 1

    def since(self, mark: int) -> tuple[Event, ...]:
        """Return the kept events after the first *mark*, oldest first."""
        newest = islice(reversed(self._events), max(0, self.count - mark))
        return tuple(newest)[::-1]

    def text(self) -> str:
        """Return the kept events, one line each."""
        return "".join(f"{event}\n" for event in self._events)
