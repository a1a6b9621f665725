"""Lifts: whether one may be sent to another floor. Pure.

A lift is any part that takes a floor; its door is a part of its own, or of the same device.
"""

from collections.abc import Mapping
from typing import Final

from homebot.devices.value import PlainValue

DOOR: Final = ("movement", "position", "contact")
"""The capabilities of a door, of which a motor's come first."""

_STATES: Final[Mapping[PlainValue, bool]] = {"closed": False, "open": True, False: False, True: True, 100.0: True}
"""Whether it is open, by value; False is also 0."""


def is_open(door: Mapping[str, PlainValue]) -> bool | None:
    """Return whether the door with these values is open; None while it moves, or if nothing is known."""
    known = [door[name] for name in ("position", "movement", "contact") if door.get(name) is not None]
    return _STATES.get(known[0]) if known else None


def why_it_stays(lift: Mapping[str, PlainValue], door: Mapping[str, PlainValue]) -> str:
    """Return why a lift is not sent anywhere; empty if nothing is in its way.

    Args:
        lift: The values of the lift.
        door: The values of its door, with None for an unknown one; empty for a lift without a door.
    """
    if session := lift.get("session"):
        return f"{session} has the lift"
    return "its door may be open" if door and is_open(door) is not False else ""
