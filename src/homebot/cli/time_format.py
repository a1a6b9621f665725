"""Moments as people and programs read them."""

from __future__ import annotations

from datetime import UTC, datetime

from homebot.messages import Time

__all__ = ["age", "ago", "iso"]

_SPANS = ((86_400, "d"), (3600, "h"), (60, "min"), (1, "s"))


def age(moment: Time, now: float) -> str:
    """Return the time from *moment* to *now*, in the largest unit that fits."""
    seconds = max(0.0, now - moment.to_seconds())
    size, unit = next((one for one in _SPANS if seconds >= one[0]), _SPANS[-1])
    return f"{seconds / size:.0f} {unit}"


def ago(moment: Time, now: float) -> str:
    """Return :func:`age` as in ``5 s ago``; ``now`` below a second."""
    return f"{age(moment, now)} ago" if now - moment.to_seconds() >= _SPANS[-1][0] else "now"


def iso(moment: Time) -> str:
    """Return *moment* in ISO 8601, UTC, to the millisecond."""
    found = datetime.fromtimestamp(moment.sec, UTC).replace(microsecond=moment.nanosec // 1000)
    return found.isoformat(timespec="milliseconds").replace("+00:00", "Z")
