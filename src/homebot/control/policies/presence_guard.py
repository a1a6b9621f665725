"""The presence guard: what annoys or hurts people is not done by itself where somebody is. Pure."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

from homebot.control.command import IssuedCommand
from homebot.control.policies.closed_room import stayed_in
from homebot.control.policies.facts import Facts
from homebot.control.policies.house import OCCUPANCY
from homebot.control.policies.settings import PresenceGuardSettings
from homebot.control.policies.verdict import FactUsed, Verdict

__all__ = ["Presence", "judge_presence", "person_at", "presence_in"]

Presence: TypeAlias = Literal["present", "absent", "unknown"]

NAME: Final = "presence_guard"

_NOT_CONCERNED: Final = Verdict(NAME, allowed=True)


def judge_presence(settings: PresenceGuardSettings, command: IssuedCommand, facts: Facts) -> Verdict:
    """Refuse a command of an app where somebody is, or where that is unknown, if it is one of *settings*."""
    if command.is_wish or not any(pattern.fits(command, facts) for pattern in settings.commands):
        return _NOT_CONCERNED
    room = command.device.area
    if not room:
        return Verdict(
            NAME, allowed=False, reason="the room of the device is unknown, and so is whether somebody is there"
        )
    presence, used = presence_in(room, facts, settings.absent_after)
    if presence == "absent" and (stayed := _stayed(settings, room, facts)) is not None:
        detected = f"{stayed.name} was on {facts.age(stayed.since):.0f} s ago"
        reason = f"somebody is in {room}: {detected}, and no door has been opened since"
        return Verdict(NAME, allowed=False, reason=reason, facts=(stayed,))
    if presence != "present" and (person := person_at(command, facts, settings.absent_after)) is not None:
        changed = f"{command.label} changed {facts.now - person.since:.0f} s ago, and no command explains it"
        reason = f"somebody may be in {room}: {changed}"
        return Verdict(NAME, allowed=False, reason=reason, facts=(person,))
    return Verdict(NAME, presence == "absent", _reason(presence, room, used, facts), used)


def presence_in(room: str, facts: Facts, absent_after: float) -> tuple[Presence, tuple[FactUsed, ...]]:
    """Return whether somebody is in *room*, and the readings that tell.

    Present if any sensor detects motion, or did within *absent_after* seconds; unknown if there is no sensor, or any
    of them is silent, has never detected anybody, or was first heard within these seconds; absent otherwise.
    """
    found: list[FactUsed] = []
    doubtful: list[FactUsed] = []
    house = facts.house
    for one in house.readings(room, OCCUPANCY):
        used = FactUsed(f"{OCCUPANCY} of {one.sensor}", one.value, one.since)
        is_proven = one.value is False and one.sensor in house.detections
        is_recent = is_proven and facts.age(one.since) < absent_after
        if one.value is True or (is_recent and house.detected_since(one.sensor) is not None):
            return "present", (used,)
        (found if is_proven and not is_recent else doubtful).append(used)
    if doubtful or not found:
        return "unknown", tuple(doubtful)
    return "absent", tuple(found)


def person_at(command: IssuedCommand, facts: Facts, within: float) -> FactUsed | None:
    """Return a change of the commanded part within the last seconds that no command explains: a person at its switch.

    The switch reports sooner than the motion sensor.
    """
    change = facts.timeline_of(command.device, command.part).unexplained(facts.monotonic - within)
    if change is None:
        return None
    return FactUsed(f"{change.capability} of {command.target}", change.value, facts.now - facts.monotonic + change.at)


def _stayed(settings: PresenceGuardSettings, room: str, facts: Facts) -> FactUsed | None:
    contacts = settings.contacts_of(room)
    return stayed_in(room, contacts, facts, settings.absent_after) if contacts else None


def _reason(presence: Presence, room: str, used: tuple[FactUsed, ...], facts: Facts) -> str:
    match presence:
        case "absent":
            return f"nobody is in {room}"
        case "unknown":
            return f"nothing tells whether somebody is in {room}: {_doubt(used, facts)}"
    (one,) = used
    if one.value is True:
        return f"somebody is in {room}: {_shown(one)} is on"
    return f"somebody was in {room} {facts.age(one.since):.0f} s ago: {_shown(one)}"


def _shown(used: FactUsed) -> str:
    """Return the fact in words: the id of the sensor's part tells people nothing."""
    return used.name.partition("#")[0]


def _doubt(used: tuple[FactUsed, ...], facts: Facts) -> str:
    """Return why nothing tells, and what to do about it."""
    if not facts.house.is_known:
        return "the devices of the home are not known yet"
    if not used:
        return "it has no motion sensor"
    reasons: list[str] = []
    if silent := [_shown(one) for one in used if one.value is None]:
        reasons.append(f"no current {' or '.join(silent)}")
    for one in used:
        sensor, shown = (name.removeprefix(f"{OCCUPANCY} of ") for name in (one.name, _shown(one)))
        if one.value is False and sensor in facts.house.detections:
            reasons.append(f"{shown} has been heard for only {facts.age(one.since):.0f} s")
        elif one.value is False:
            reasons.append(f"{shown} has never detected anybody; walk past it once")
    return "; ".join(reasons)
