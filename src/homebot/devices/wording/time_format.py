"""Times as text for people and programs."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from homebot.messages import Time

_NANOSECONDS = 1_000_000_000
_SPANS = ((86_400, "d"), (3600, "h"), (60, "min"), (1, "s"))


def to_seconds(time: Time) -> float:
    """Return *time* in seconds since 1970."""
    return time.sec + time.nanosec / 1e9


def from_seconds(seconds: float) -> dict[str, int]:
    """Return a time in *seconds* since 1970 as a field of a request."""
    sec, nanosec = divmod(round(seconds * _NANOSECONDS), _NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def age(time: Time, now: float) -> str:
    """Return the age of *time* at *now*, in the largest unit that fits."""
    return age_text(now - to_seconds(time))


def age_text(seconds: float) -> str:
    """Return a number of seconds in the largest unit that fits: ``4 min``."""
    seconds = max(0.0, seconds)
    size, unit = next((span for span in _SPANS if seconds >= span[0]), _SPANS[-1])
    return f"{seconds / size:.0f} {unit}"


def ago(time: Time, now: float) -> str:
    """Return :func:`age` in the form ``5 s ago``; ``now`` below a second."""
    return f"{age(time, now)} ago" if now - to_seconds(time) >= _SPANS[-1][0] else "now"


def iso(time: Time) -> str:
    """Return *time* in ISO 8601, UTC, to the nearest millisecond, because float seconds are inexact."""
    more, milliseconds = divmod(round(time.nanosec / 1_000_000), 1000)
    return f"{_to_the_second(time.sec + more)}.{milliseconds:03}Z"


@lru_cache(maxsize=4096)
def _to_the_second(sec: int) -> str:
    """Return the time to the second; cached, because many devices report in the same second."""
    return datetime.fromtimestamp(sec, UTC).strftime("%Y-%m-%dT%H:%M:%S")
