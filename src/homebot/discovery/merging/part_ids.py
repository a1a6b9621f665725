"""The ids of the parts of a device, which stay the same while announcements come and go. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

__all__ = ["MAX_LOST", "NO_IDS", "Named", "PartIds", "PartPlace", "lost_ids", "part_ids"]

PartPlace: TypeAlias = tuple[str, str, str]
"""Gateway, key, and id of the part there."""

PartIds: TypeAlias = Mapping[PartPlace, str]
"""The id that the part announced at each place had."""

NO_IDS: PartIds = MappingProxyType({})

MAX_LOST = 1000
"""Places of a device without a part now, and with ids that are remembered; the oldest are forgotten."""


class Named(NamedTuple):
    """A part that needs an id.

    Attributes:
        places: Where it is announced, each with the age of the announcement: the smaller number is the older one.
    """

    name: str
    label: str
    places: Sequence[tuple[int, PartPlace]]


def part_ids(parts: Sequence[Named], known: PartIds) -> tuple[str, ...]:
    """Return the ids of *parts*, each another one.

    A part has the id that it had, by its oldest announcement; a new one gets its name in its best announcement. Of two
    that were one, the one of that name has the id.
    """
    held = _claimed_ids(parts, known) if known else {}
    taken = set(held.values())
    found = []
    for number, part in enumerate(parts):
        part_id = held.get(number)
        if part_id is None:
            part_id = part.name
            if part_id in taken:
                part_id = f"{part.label}/{part_id}"
            while part_id in taken:
                part_id += "'"
            taken.add(part_id)
        found.append(part_id)
    return tuple(found)


def lost_ids(known: PartIds, places: Iterable[PartPlace]) -> PartIds:
    """Return the entries of *known* to remember beside *places*: ids that differ from the part's name there."""
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
