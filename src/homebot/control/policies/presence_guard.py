"""Presence guard: apps do not annoy or hurt people in the room. Pure."""

from operator import attrgetter
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.control.policies.house import OCCUPANCY, SensorReading
from homebot.devices.query.terms import CanDo, Or, Query
from homebot.support.folding import fold
from homebot.units import Seconds
from homebot.words.patterns import CommandPattern, Patterns, pattern_of_type

Presence: TypeAlias = Literal["present", "absent", "unknown"]

NAME: Final = "presence_guard"

_TURN_OFF: Final = "turn off"
_IS_PRESENCE: Final = attrgetter("is_presence")

CONTACT: Final = "contact"
"""The capability of a door contact; true means open."""


def _annoying() -> tuple[CommandPattern, ...]:
    return (
        *(pattern_of_type(_TURN_OFF, word) for word in ("light", "plug", "switch")),
        *(pattern_of_type("close", word) for word in ("window_covering", "closure", "water_valve")),
    )


def _as_tuple(value: object) -> object:
    """Return an array as a tuple: pydantic rejects a list in a table that may also be ``true``."""
    return tuple(value) if isinstance(value, list) else value


_Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]
_Contacts: TypeAlias = Annotated[tuple[_Name, ...], BeforeValidator(_as_tuple), Field(min_length=1, max_length=50)]


class AbsentAfter(BaseModel):
    """Seconds without a detection after which a sensor says that nobody is there.

    Attributes:
        motion: For motion sensors: a person who reads does not move.
        presence: For presence sensors, such as radars, which detect people who sit still.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    motion: Seconds = 1200.0
    presence: Seconds = 60.0

    def of(self, reading: SensorReading) -> float:
        """Return the seconds for the sensor of *reading*."""
        return min(self.presence, self.motion) if reading.is_presence else self.motion


def _by_kind(value: object) -> object:
    """Return a time such as ``1200`` or ``20min`` as that of motion sensors."""
    return {"motion": value} if isinstance(value, int | float | str) and not isinstance(value, bool) else value


class PresenceGuardSettings(PolicyTable):
    """The table ``[control.presence_guard]``.

    Attributes:
        commands: The commands that apps may not give in a room that is, or may be, occupied.
        absent_after: Seconds without a detection after which a room counts as empty, by the kind of its sensors; a
            number is that of motion sensors.
        doors: The ids or names of the contacts on all doors of a room, by room: a person who moved there after all
            doors were closed stays until one opens.
    """

    commands: Patterns = Field(default_factory=_annoying)
    absent_after: Annotated[AbsentAfter, BeforeValidator(_by_kind)] = AbsentAfter()
    doors: Annotated[dict[_Name, _Contacts], Field(max_length=1000)] = Field(default_factory=dict)

    @property
    def needs(self) -> Query:
        """The motion sensors, and the door contacts."""
        return Or((CanDo(OCCUPANCY), CanDo(CONTACT))) if self.doors else CanDo(OCCUPANCY)

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse such a command of an app in a room that is, or may be, occupied."""
        pattern = next((one for one in self.commands if not command.is_by_person and one.fits(command, facts)), None)
        if pattern is None:
            return Verdict(NAME, allowed=True)
        room = command.device.area
        if not room:
            reason = "the room of the device is unknown, so somebody may be there"
            return Verdict(NAME, allowed=False, reason=reason)
        if pattern.verb == _TURN_OFF and (robot := facts.robot_in(room)):
            return Verdict(NAME, allowed=False, reason=f"the robot {robot} is on its way in {room} or to it")
        presence, used = presence_in(room, facts, self.absent_after)
        if presence == "absent" and (remaining := remaining_person(room, self, facts)) is not None:
            detected = f"{_show(remaining)} was on {facts.age(remaining.since):.0f} s ago"
            reason = f"somebody is in {room}: {detected}, and no door has been opened since"
            return Verdict(NAME, allowed=False, reason=reason, facts=(remaining,))
        if presence != "present":  # a switch reports before a motion sensor
            readings = facts.house.readings(room, OCCUPANCY)
            decisive = [*filter(_IS_PRESENCE, readings)] or readings
            unseen_for = max(map(self.absent_after.of, decisive), default=self.absent_after.motion)
            change = facts.timeline_of(command.device, command.part).unexplained(facts.monotonic - unseen_for)
            if change is not None:
                changed = f"changed {facts.monotonic - change.at:.0f} s ago, and no command explains it"
                at, name = facts.now - facts.monotonic + change.at, f"{change.capability} of {command.target}"
                reason = f"somebody may be in {room}: {command.label} {changed}"
                return Verdict(NAME, allowed=False, reason=reason, facts=(FactUsed(name, change.value, at),))
        return Verdict(NAME, presence == "absent", _reason(presence, room, used, facts), used)

    def contacts_of(self, room: str) -> tuple[str, ...]:
        """Return the contacts on all doors of *room*; none if unknown."""
        if not self.doors:
            return ()
        return next((contacts for name, contacts in self.doors.items() if fold(name) == fold(room)), ())


def presence_in(room: str, facts: Facts, absent_after: AbsentAfter) -> tuple[Presence, tuple[FactUsed, ...]]:
    """Return whether *room* is occupied, and the readings behind it.

    Present: a sensor detects somebody, or did within its seconds of *absent_after*. Unknown: there is no sensor, or one
    is silent, has never detected motion, or was heard for the first time, or again, within these seconds. Absent
    otherwise. Where a presence sensor sees nobody, motion sensors are waited for no longer than it is.
    """
    readings: dict[Presence, list[FactUsed]] = {"present": [], "unknown": [], "absent": []}
    longest = absent_after.motion
    for reading in sorted(facts.house.readings(room, OCCUPANCY), key=_IS_PRESENCE, reverse=True):
        used = FactUsed(f"{OCCUPANCY} of {reading.sensor}", reading.value, max(reading.since, reading.heard_since))
        within = min(longest, absent_after.of(reading))
        presence_by_it = _presence_by(reading, used.since, facts, within)
        if reading.is_presence and presence_by_it == "absent":
            longest = within
        readings[presence_by_it].append(used)
    if readings["present"]:
        return "present", (readings["present"][0],)
    presence: Presence = "unknown" if readings["unknown"] or not readings["absent"] else "absent"
    return presence, tuple(readings[presence])


def _presence_by(reading: SensorReading, since: float, facts: Facts, absent_after: float) -> Presence:
    """Return the presence according to one sensor, whose value is certain from *since* on."""
    if reading.value is True:
        return "present"
    if reading.value is not False or reading.sensor not in facts.house.detections:
        return "unknown"
    if facts.age(since) >= absent_after:
        return "absent"
    is_seen = reading.since >= reading.heard_since and facts.house.detected_since(reading.sensor) is not None
    return "present" if is_seen else "unknown"


def remaining_person(room: str, settings: PresenceGuardSettings, facts: Facts) -> FactUsed | None:
    """Return the detection of a person who has not left *room* since its doors were closed; None if there is none.

    The person was detected after all doors were closed: a sensor began to detect motion then, or still did so
    ``absent_after`` seconds later, which is longer than it reports the motion of a person who left.
    """
    contacts = [facts.house.reading_of(name, CONTACT) for name in settings.contacts_of(room)]
    closed = [contact for contact in contacts if contact is not None and contact.value is False]
    if not contacts or len(closed) < len(contacts):
        return None
    closed_for = min(facts.age(reading.since) for reading in closed)
    for reading in facts.house.readings(room, OCCUPANCY):
        began = facts.house.detected_since(reading.sensor)
        if began is None:
            continue
        has_moved = facts.age(began) <= closed_for
        if has_moved or (
            reading.value is False and facts.age(reading.since) + settings.absent_after.of(reading) <= closed_for
        ):
            return FactUsed(f"{OCCUPANCY} of {reading.sensor}", value=True, since=began)
    return None


def _reason(presence: Presence, room: str, used: tuple[FactUsed, ...], facts: Facts) -> str:
    match presence:
        case "absent":
            return f"nobody is in {room}"
        case "unknown":
            return f"it is unknown whether anybody is in {room}: {_doubt(used, facts)}"
    (fact,) = used
    if fact.value is True:
        return f"somebody is in {room}: {_show(fact)} is on"
    return f"somebody was in {room} {facts.age(fact.since):.0f} s ago: {_show(fact)}"


def _show(used: FactUsed) -> str:
    """Return the name of the fact, without the id of the sensor's part."""
    return used.name.partition("#")[0]


def _doubt(used: tuple[FactUsed, ...], facts: Facts) -> str:
    """Return why the presence is unknown, and the remedy."""
    if not facts.house.is_known:
        return "the devices of the home are not known yet"
    if not used:
        return "it has no motion sensor"
    silent = " or ".join(_show(reading) for reading in used if reading.value is None)
    doubts = [f"no current {silent}"] if silent else []
    for reading in used:
        sensor, shown = (name.removeprefix(f"{OCCUPANCY} of ") for name in (reading.name, _show(reading)))
        if reading.value is False and sensor in facts.house.detections:
            doubts.append(f"{shown} has been heard for only {facts.age(reading.since):.0f} s")
        elif reading.value is False:
            doubts.append(f"{shown} has never detected anybody; walk past it once")
    return "; ".join(doubts)
