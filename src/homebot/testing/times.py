"""Points in time as people write them in a test."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from typing import Final

from homebot.errors import UsageError

__all__ = ["next_moment", "parse_time"]

_TIME_OF_DAY: Final = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?", re.ASCII)


def parse_time(when: str | datetime) -> datetime:
    """Return a point in time in UTC.

    Args:
        when: A date-time, or its text as in ``2026-01-01`` or ``2026-01-01 22:00``; without a time zone it is UTC.

    Raises:
        UsageError: It cannot be read.
    """
    if isinstance(when, str):
        try:
            when = datetime.fromisoformat(when.strip())
        except ValueError:
            raise UsageError(f"{when!r} is no point in time; write it like 22:00 or 2026-01-01 22:00") from None
    return when.replace(tzinfo=UTC) if when.tzinfo is None else when.astimezone(UTC)


def next_moment(now: datetime, when: str | datetime) -> datetime:
    """Return the point in time that *when* means, which is later than *now*.

    Args:
        now: The present, in UTC.
        when: As :func:`parse_time` takes it, or a time of day such as ``22:00`` or ``22:00:30``: the next one in UTC,
            which is tomorrow's where it is that time now.

    Raises:
        UsageError: It cannot be read, or is past.
    """
    time_of_day = _TIME_OF_DAY.fullmatch(when.strip()) if isinstance(when, str) else None
    if time_of_day is not None:
        hour, minute, second = (int(part or 0) for part in time_of_day.groups())
        moment = now.replace(hour=hour, minute=minute, second=second, microsecond=0)
        return moment if moment > now else moment + timedelta(days=1)
    moment = parse_time(when)
    if moment < now:
        raise UsageError(f"{moment:%Y-%m-%d %H:%M:%S} is past: it is {now:%Y-%m-%d %H:%M:%S} in the house")
    return moment
