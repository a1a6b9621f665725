"""Reachability of a device and its parts, by all of its announcements. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from homebot.devices import Reachability
from homebot.discovery.source_record import Reach, SourceKey, SourceRecord

__all__ = ["NOT_REPORTED", "offline_parts", "reachability"]

_SourceReach: TypeAlias = tuple[SourceRecord, str, Reach | None]
"""Reachability of a part, as one announcement has it."""

NOT_REPORTED = Reachability()
"""Reachability of a device of which no announcement reports it."""


def reachability(sources: Iterable[SourceRecord]) -> Reachability:
    """Return whether a device can be reached: the combined reachability of its parts.

    One that can be reached is enough. Where some deny it, none affirms it, and others, of which nothing is known,
    reported since, it is unknown. Without their link gateways know nothing; without any it cannot be reached.
    """
    known = tuple(sources)
    linked = [one for one in known if not one.is_lost]
    lost = [one.lost for one in known if one.lost is not None]
    if lost and not linked:
        newest = max(lost, key=lambda one: one.since.to_seconds())
        return Reachability(state="no", since=newest.since, why=newest.why)
    return _combined(_source_reaches(linked))


def offline_parts(
    sources: Mapping[SourceKey, SourceRecord], places: Mapping[tuple[str, str, str], int], ids: Mapping[int, str]
) -> tuple[str, ...]:
    """Return the ids of the parts that cannot be reached, by the same rule for each."""
    reports: dict[int, list[_SourceReach]] = {}
    for (gateway, key, part), place in places.items():
        source = sources.get((gateway, key))
        if source is not None:
            linked = reports.setdefault(place, [])
            if not source.is_lost:
                linked.append((source, part, source.reach_of(part)))
    return tuple(
        ids[place] for place in sorted(reports) if not reports[place] or _combined(reports[place]).state == "no"
    )


def _source_reaches(sources: Iterable[SourceRecord]) -> list[_SourceReach]:
    found: list[_SourceReach] = []
    for source in sources:
        if len(source.reach) == 1 and "" in source.reach:
            found.append((source, "", source.reach[""]))
        elif not source.reach:
            found.append((source, "", None))
        else:
            found += [(source, part.id, source.reach_of(part.id)) for part in source.sighting.parts]
    return found


def _combined(reports: list[_SourceReach]) -> Reachability:
    """Return the newest answer of the first kind that any of *reports* has: yes, no, unknown."""
    for value in (True, False, None):
        answers = [(source, part, one) for source, part, one in reports if one is not None and one.value is value]
        if answers:
            source, part, reach = max(answers, key=lambda one: one[2].heard_at)
            label = source.label if source.sighting.convention else "it"  # a key of a gateway tells a person nothing
            is_all_of_it = all(one is not None and one.value is value for other, _, one in reports if other is source)
            label = label if is_all_of_it or part in label else f"{label} ({part})"
            return _answer(label, source, reach, reports)
    return NOT_REPORTED


def _answer(label: str, source: SourceRecord, reach: Reach, reports: list[_SourceReach]) -> Reachability:
    if reach.value is None:
        why = f"{label} was reported offline, but it sends messages"
        return Reachability(state="unknown", since=reach.since, why=why)
    if reach.value:
        return Reachability(state="yes", since=reach.since, why=f"{label} is online, {_according(source, reach)}")
    later = _reported_later(reports, reach.heard_at)
    if later is None:
        return Reachability(state="no", since=reach.since, why=f"{label} is offline, {_according(source, reach)}")
    why = f"{label} is offline, but {later.label} reported since"
    return Reachability(state="unknown", since=later.seen_at, why=why)


def _according(source: SourceRecord, reach: Reach) -> str:
    reporter = "it or its last will" if source.sighting.convention else source.key[0]
    return f"according to {reporter}" + ("" if reach.live else ", in a retained message")


def _reported_later(reports: list[_SourceReach], since: float) -> SourceRecord | None:
    """Return an announcement of unknown or doubtful reachability that the device used later than *since*."""
    undecided = (source for source, _, one in reports if one is None or one.value is None)
    return next((source for source in undecided if source.confirmed and source.heard_at > since), None)
