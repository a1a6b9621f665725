"""Reachability of a device and its parts, by all of its announcements. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from homebot.devices import Reachability
from homebot.discovery.source_record import Reach, SourceKey, SourceRecord

__all__ = ["offline_parts", "reachability"]

_Said: TypeAlias = tuple[SourceRecord, str, Reach | None]
"""What an announcement says of one of its parts."""

_NOT_SAID = Reachability()


def reachability(claims: Iterable[SourceRecord]) -> Reachability:
    """Return whether a device can be reached: what its parts are together.

    One that can be reached is enough. Where some deny it, none affirms it, and others, of which nothing was said, spoke
    since, it is unknown.
    """
    sources = tuple(claims)
    for source in sources:
        if source.reach:
            return _together(_said(sources))
    return _NOT_SAID


def offline_parts(
    claims: Mapping[SourceKey, SourceRecord], places: Mapping[tuple[str, str, str], int], ids: Mapping[int, str]
) -> tuple[str, ...]:
    """Return the ids of the parts that cannot be reached, by the same rule for each.

    Args:
        claims: The announcements of the device.
        places: Which part of the device each of theirs is.
        ids: The ids of those.
    """
    said: dict[int, list[_Said]] = {}
    for (gateway, key, part), place in places.items():
        claim = claims.get((gateway, key))
        if claim is not None:
            said.setdefault(place, []).append((claim, part, claim.reach_of(part)))
    return tuple(ids[place] for place in sorted(said) if _together(said[place]).state == "no")


def _said(claims: Iterable[SourceRecord]) -> list[_Said]:
    found: list[_Said] = []
    for claim in claims:
        if len(claim.reach) == 1 and "" in claim.reach:
            found.append((claim, "", claim.reach[""]))
        elif not claim.reach:
            found.append((claim, "", None))
        else:
            found += [(claim, part.id, claim.reach_of(part.id)) for part in claim.sighting.parts]
    return found


def _together(said: list[_Said]) -> Reachability:
    known = [(claim, part, one) for claim, part, one in said if one is not None]
    if not known:
        return _NOT_SAID
    for state, value in (("yes", True), ("no", False), ("unknown", None)):
        answers = [one for one in known if one[2].value is value]
        if not answers:
            continue
        claim, part, reach = max(answers, key=lambda one: one[2].heard)
        label = f"{claim.label} ({part})" if part and part not in claim.label else claim.label
        if value is False and (speaker := _speaker(said, reach.heard)) is not None:
            why = f"{label} is offline, but {speaker.label} reported since"
            return Reachability(state="unknown", since=speaker.seen_at, why=why)
        if value is None:
            why = f"{label} was reported offline, but it sends messages"
            return Reachability(state="unknown", since=reach.since, why=why)
        kept = "" if reach.live else ", in a retained message"
        why = f"{label} is {'online' if value else 'offline'}, according to it or its last will{kept}"
        return Reachability(state="yes" if state == "yes" else "no", since=reach.since, why=why)
    return _NOT_SAID


def _speaker(said: list[_Said], since: float) -> SourceRecord | None:
    """One of which nothing was said, or what was said is in doubt, that spoke itself later than *since*."""
    undecided = (claim for claim, _, one in said if one is None or one.value is None)
    return next((claim for claim in undecided if claim.confirmed and claim.heard_at > since), None)
