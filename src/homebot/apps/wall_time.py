"""Local times of day as moments, over days of 23 and 25 hours. Pure.

A time that a day lacks becomes the end of the gap; of a time that occurs twice, the first is used.
"""

from dataclasses import dataclass
from datetime import date, datetime, time, tzinfo
from typing import final

from homebot.words.days import CalendarDays


@final
@dataclass(frozen=True, slots=True)
class TimeOfDay:
    """A time on some days."""

    time: time
    days: CalendarDays

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if the day is not among its days."""
        return moment_of(day, self.time, zone) if self.days.has(day) else None


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
