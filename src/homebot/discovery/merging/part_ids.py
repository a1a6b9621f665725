"""The ids of a device's parts, which stay the same while announcements come and go. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

PartPlace: TypeAlias = tuple[str, str, str]
"""Gateway, key, and id of the part there."""

PartIds: TypeAlias = Mapping[PartPlace, str]
"""Former ids of parts by their place."""

NO_IDS: PartIds = MappingProxyType({})

MAX_LOST = 1000
"""Most places of a device whose ids are remembered though they have no part now; the oldest are forgotten."""


class Named(NamedTuple):
    """A part that needs an id.

    Attributes:
        places: Where it is announced, with the number of each announcement: smaller is older.
    """

    name: str
    label: str
    places: Sequence[tuple[int, PartPlace]]


def part_ids(parts: Sequence[Named], known: PartIds) -> tuple[str, ...]:
    """Return the ids of *parts*, all different.

    A part keeps the former id of its oldest announcement; a new one is named by its preferred announcement. Of two that
    used to be one, the part of that name keeps the id.
    """
    held = _claimed_ids(parts, known) if known else {}
    taken = set(held.values())
    ids = []
    for number, part in enumerate(parts):
        part_id = held.get(number)
        if part_id is None:
            part_id = part.name
            if part_id in taken:
                part_id = f"{part.label}/{part_id}"
            while part_id in taken:
                part_id += "'"
            taken.add(part_id)
        ids.append(part_id)
    return tuple(ids)


def lost_ids(known: PartIds, places: Iterable[PartPlace]) -> PartIds:
    """Return the entries of *known* to remember in addition to *places*: ids that differ from the name there."""
    there = frozenset(places)
    lost = [(place, part_id) for place, part_id in known.items() if place not in there and part_id != place[2]]
    return dict(lost[-MAX_LOST:]) if lost else NO_IDS


def _claimed_ids(parts: Sequence[Named], known: PartIds) -> dict[int, str]:
    claims: dict[str, tuple[bool, int, int]] = {}
    for number, part in enumerate(parts):
        had = min(((age, known[place]) for age, place in part.places if place in known), default=None)
        if had is not None:
            age, part_id = had
            has_same_id = any(place[2] == part_id for _, place in part.places)
            claim = (not has_same_id, age, number)
            claims[part_id] = min(claim, claims.get(part_id, claim))
    return {number: part_id for part_id, (_, _, number) in claims.items()}
