"""Moments as people and programs read them."""

from __future__ import annotations

from datetime import UTC, datetime

from homebot.messages import Time

__all__ = ["ago", "iso"]

_SPANS = ((86_400, "d"), (3600, "h"), (60, "min"), (1, "s"))


def ago(moment: Time, now: float) -> str:
    """Return how long *moment* lies before *now*, in the largest unit that fits."""
    seconds = now - moment.to_seconds()
    for size, unit in _SPANS:
        if seconds >= size:
            return f"{seconds / size:.0f} {unit} ago"
    return "now"


def iso(moment: Time) -> str:
    """Return *moment* in ISO 8601, UTC, to the millisecond."""
    found = datetime.fromtimestamp(moment.sec, UTC).replace(microsecond=moment.nanosec // 1000)
    return found.isoformat(timespec="milliseconds").replace("+00:00", "Z")
