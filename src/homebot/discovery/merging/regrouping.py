"""The devices that groups of announcements become, given the devices they belonged to. Pure."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from homebot.discovery.entry import Entry
from homebot.discovery.source_record import SourceKey, SourceRecord


class Regrouped(NamedTuple):
    """A device after regrouping.

    Attributes:
        keys: Its announcements, oldest first.
        keeps: Its former device; None for a new one.
        gone: Devices merged into it.
        parents: Devices from which some of its announcements were split off.
    """

    keys: tuple[SourceKey, ...]
    keeps: Entry | None
    gone: tuple[Entry, ...]
    parents: tuple[Entry, ...]


def regroup(
    groups: Iterable[frozenset[SourceKey]], owners: Mapping[SourceKey, Entry], sources: Mapping[SourceKey, SourceRecord]
) -> tuple[Regrouped, ...]:
    """Return the devices that *groups* of announcements describe.

    A device stays with its oldest announcement; of merged devices, the one with the oldest announcement remains.

    Args:
        owners: Their former devices; new announcements have none.
        sources: The announcements; smaller numbers are older.
    """

    def age(key: SourceKey) -> int:
        return sources[key].number

    ordered = sorted((tuple(sorted(group, key=age)) for group in groups), key=lambda keys: age(keys[0]))
    found: list[tuple[tuple[SourceKey, ...], Entry | None, list[Entry]]] = []
    kept: set[str] = set()
    for keys in ordered:
        entries = list(dict.fromkeys(owners[key] for key in keys if key in owners))
        members = frozenset(keys)
        keeps = next((one for one in entries if one.id not in kept and next(iter(one.sources)) in members), None)
        if keeps is not None:
            kept.add(keeps.id)
        found.append((keys, keeps, entries))
    return tuple(_regrouped(*one, kept) for one in found)


def _regrouped(keys: tuple[SourceKey, ...], keeps: Entry | None, entries: Iterable[Entry], kept: set[str]) -> Regrouped:
    gone = () if keeps is None else tuple(one for one in entries if one.id not in kept)
    return Regrouped(keys, keeps, gone, tuple(one for one in entries if one.id in kept and one is not keeps))
