"""Times of the house in its own zone, as text."""

from __future__ import annotations

from datetime import datetime, tzinfo
from typing import TYPE_CHECKING, cast

from homebot.clock import read_zone
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age, to_seconds
from homebot.errors import UsageError

if TYPE_CHECKING:
    from homebot.messages import Time


def zone_of(name: str) -> tzinfo:
    """Return the zone of the home; the computer's if it is unknown here."""
    try:
        return read_zone(name)
    except UsageError:
        return read_zone("")


def local_text(time: Time, zone: tzinfo) -> str:
    """Return *time* with its day: ``Fri 27 Nov 22:00 CET``."""
    return f"{datetime.fromtimestamp(to_seconds(time), zone):%a %d %b %H:%M %Z}"


def next_text(time: Time, now: float, zone: tzinfo) -> str:
    """Return a time to come, and in how long; empty for 0. *now* is in seconds since the Unix epoch."""
    if not time.sec:
        return ""
    left = age(cast("Time", JsonMessage({"sec": int(now), "nanosec": 0})), to_seconds(time))
    return f"{local_text(time, zone)}, in {left}"
