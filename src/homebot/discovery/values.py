"""What devices tell of themselves, noted at the announcement through which they told it. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.devices import State
from homebot.devices.report import Reading
from homebot.discovery.claim import Claim, Reach, Told
from homebot.discovery.entry import Entry
from homebot.messages import Time

__all__ = ["can_tell", "is_denied", "reach", "state_of", "tell"]


def can_tell(claim: Claim, part_id: str, capability: str) -> bool:
    """Whether a part with that capability was announced."""
    part = next((one for one in claim.sighting.parts if one.id == part_id), None)
    return part is not None and any(one.name == capability for one in part.capabilities)


def tell(claim: Claim, reading: Reading, stamp: Time, now: float, *, live: bool) -> Told | None:
    """Note a value of a part; what the broker had kept never overwrites what was told live.

    Args:
        claim: Through which announcement it was told.
        reading: The value.
        stamp: When it was told.
        now: The same on the clock that is never set.
        live: Whether the device told it itself.

    Returns:
        What is known now, where the value is a new one; else None.
    """
    place = (reading.part, reading.capability)
    value = reading.value.plain()
    known = claim.told.get(place)
    if known is None:
        known = claim.told[place] = Told(value, stamp, stamp, live, now)
        return known
    if known.live and not live:
        return None
    is_same = known.value == value and type(known.value) is type(value)
    known.told_at, known.live, known.heard = stamp, live, now
    if is_same:
        return None
    known.value, known.since = value, stamp
    return known


def reach(entry: Entry, claim: Claim, reading: Reading, stamp: Time, now: float, *, live: bool) -> None:
    """Note whether a device, or one of its parts, can be reached."""
    if reading.part and all(one.id != reading.part for one in claim.sighting.parts):
        return
    value = reading.value.plain()
    answer = value if isinstance(value, bool) else None
    known = claim.reach.get(reading.part)
    if known is not None and known.value is answer:
        known.live = live
        return
    claim.reach[reading.part] = Reach(answer, stamp, now, live)
    entry.is_denied = is_denied(entry.claims.values())


def is_denied(claims: Iterable[Claim]) -> bool:
    """Whether any of *claims* says that something cannot be reached."""
    return any(one.value is False for claim in claims for one in claim.reach.values())


def state_of(part_id: str, reading: Reading, told: Told) -> State:
    """Return the message that tells a value."""
    return State.of_checked(
        part=part_id,
        capability=reading.capability,
        value=reading.value,
        since=told.since,
        told_at=told.told_at,
        live=told.live,
    )
