"""A closed room: who moved in it after its doors were closed is still there until one opens. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from homebot.control.policies.facts import Facts
from homebot.control.policies.house import OCCUPANCY
from homebot.control.policies.verdict import FactUsed

__all__ = ["CONTACT", "stayed_in"]

CONTACT: Final = "contact"
"""The capability of a door contact; true is open."""


def stayed_in(room: str, contacts: Iterable[str], facts: Facts, absent_after: float) -> FactUsed | None:
    """Return the detection that shows that somebody has not left *room*; None where nothing shows it.

    A sensor began to detect somebody after all doors were closed; or it still did *absent_after* seconds later, which
    is more than the time that it holds the motion of somebody who left.

    Args:
        room: The room.
        contacts: The ids or names of the contacts on all its doors.
        facts: The facts.
        absent_after: See above.
    """
    closed_for = _closed_for(contacts, facts)
    if closed_for is None:
        return None
    for one in facts.house.readings(room, OCCUPANCY):
        began = facts.house.detected_since(one.sensor)
        if began is None:
            continue
        has_moved = facts.age(began) <= closed_for
        if has_moved or (one.value is False and facts.age(one.since) + absent_after <= closed_for):
            return FactUsed(f"{OCCUPANCY} of {one.sensor}", value=True, since=began)
    return None


def _closed_for(contacts: Iterable[str], facts: Facts) -> float | None:
    """Return for how many seconds all doors have been closed; None where one is open or unknown, or there are none."""
    readings = [facts.house.reading_of(one, CONTACT) for one in contacts]
    if not readings or any(one is None or one.value is not False for one in readings):
        return None
    return min(facts.age(one.since) for one in readings if one is not None)
