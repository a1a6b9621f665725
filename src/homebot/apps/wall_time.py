"""Local times of day as moments, over days of 23 and 25 hours. Pure.

A time that a day lacks becomes the end of the gap; of a time that occurs twice, the first is used.
"""

import re
from dataclasses import dataclass
from datetime import date, datetime, time, tzinfo
from typing import Final, final

from homebot.errors import UsageError
from homebot.support.similar import did_you_mean

LONGEST_OFFSET: Final = 43_200.0
"""Seconds from an event of the sun, so that each stays on its own day."""

_DAYS: Final = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_SHORTEST: Final = 3
_TIME: Final = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?", re.ASCII)


@final
@dataclass(frozen=True, slots=True)
class TimeOfDay:
    """A time on some days of the week."""

    time: time
    days: frozenset[int]

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if the day is not among its days."""
        return moment_of(day, self.time, zone) if day.weekday() in self.days else None


def read_time(text: str) -> time:
    """Return the time of day *text*, such as ``22:00`` or ``7:30:15``.

    Raises:
        UsageError: It is not a time of day.
    """
    if type(text) is not str or (found := _TIME.fullmatch(text.strip())) is None:
        raise UsageError(f"{text!r} is not a time of day; write it like 22:00 or 7:30:15")
    hour, minute, second = (int(part or 0) for part in found.groups())
    return time(hour, minute, second)


def read_days(text: str) -> frozenset[int]:
    """Return the days of the week *text*, such as ``mon-fri`` or ``sat,sun``; Monday is 0, and empty text is all.

    Raises:
        UsageError: A day does not exist.
    """
    if type(text) is not str:
        raise UsageError(f"days: {text!r} is not a text; write it like mon-fri or sat,sun")
    found: set[int] = set()
    for part in filter(None, text.replace(" ", "").lower().split(",")):
        first, dash, last = part.partition("-")
        begin = _day(first)
        found |= {(begin + one) % 7 for one in range((_day(last) - begin) % 7 + 1 if dash else 1)}
    return frozenset(found or range(7))


def moment_of(day: date, at: time, zone: tzinfo) -> float:
    """Return the moment of *at* on *day* in *zone*, in seconds since the Unix epoch."""
    wanted = datetime.combine(day, at, zone)
    moment = wanted.timestamp()
    if datetime.fromtimestamp(moment, zone).time() == at:
        return moment
    low, high = wanted.replace(fold=1).timestamp(), moment  # around a clock change
    before = datetime.fromtimestamp(low, zone).utcoffset()
    while high - low > 1:
        middle = (low + high) // 2
        if datetime.fromtimestamp(middle, zone).utcoffset() == before:
            low = middle
        else:
            high = middle
    return high


def _day(name: str) -> int:
    for number, day in enumerate(_DAYS):
        if len(name) >= _SHORTEST and f"{day}s".startswith(name):
            return number
    hint = did_you_mean(name, [day[:_SHORTEST] for day in _DAYS], "write it like mon-fri or sat,sun")
    raise UsageError(f"days: there is no day {name!r}; {hint}")
