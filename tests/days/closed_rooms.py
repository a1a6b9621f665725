"""The refusals of the presence guard that rest on closed doors alone, held against the truth."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from tests.days.living import LivedDay
from tests.days.random_day import RandomDay
from tests.days.told import RECONNECTED

from homebot.devices.journal_messages import JournalEntry
from homebot.house.sensors import MotionSensor

_CLAIM: Final = "no door has been opened since"
_ROUNDING: Final = 1.0


@dataclass(frozen=True, slots=True)
class ClosedRoomRefusal:
    """A command that was refused because somebody is in a room whose doors have been closed since they moved.

    Without this rule it would have been allowed: every motion sensor says that nobody is there.

    Attributes:
        command: The id of the command.
        room: The room.
        awake: How many were awake there.
        there: How many were there.
        is_sound: Whether the rule must be right: each door of the room has a listed contact, these and the motion
            sensors have no fault and were in touch since the motion, which was somebody's in truth, and the sensors
            hold motion for less than the guard waits.
    """

    command: str
    room: str
    awake: int
    there: int
    is_sound: bool

    @property
    def is_wrong(self) -> bool:
        """Whether nobody was there although the rule must be right."""
        return self.is_sound and not self.there


def closed_room_refusals(day: RandomDay, lived: LivedDay) -> list[ClosedRoomRefusal]:
    """Return each refusal of the presence guard that rests on closed doors alone."""
    return [
        _refusal(one, day, lived)
        for one in lived.entries
        if one.kind == "judged" and not one.verdicts[0].allowed and _CLAIM in one.verdicts[0].reason
    ]


def _refusal(entry: JournalEntry, day: RandomDay, lived: LivedDay) -> ClosedRoomRefusal:
    room = lived.rooms[lived.names[entry.device]]
    awake, there = lived.presence[entry.command][room]
    detected = entry.verdicts[0].facts[0].since.to_seconds() - lived.midnight
    judged = entry.at.to_seconds() - lived.midnight
    return ClosedRoomRefusal(entry.command, room, awake, there, _is_sound(room, detected, judged, day))


def _is_sound(room: str, detected: float, judged: float, day: RandomDay) -> bool:
    tables: dict[str, Any] = dict(day.day.house)
    contacts = day.doors[room]
    doors = {frozenset((one, other)) for one, table in tables["rooms"].items() for other in table.get("doors", ())}
    if sum(room in door for door in doors) != len(contacts):
        return False
    devices: dict[str, dict[str, Any]] = tables["devices"]
    motions = {name: one for name, one in devices.items() if one["kind"] == "motion" and one["room"] == room}
    sensors = (*contacts, *motions)
    if any(devices[name].get("faults") for name in sensors):
        return False
    if any(one.get("hold", MotionSensor.hold) >= day.absent_after for one in motions.values()):
        return False
    return not _is_doubtful(sensors, detected - _ROUNDING, judged, day)


def _is_doubtful(sensors: Sequence[str], since: float, until: float, day: RandomDay) -> bool:
    """Return whether something may have been lost meanwhile, or a motion sensor was worked without anybody there."""
    return any(
        event.at - RECONNECTED <= until
        and event.at + event.lasts + RECONNECTED >= since
        and (
            event.what == "restart" or (event.device in sensors and (event.what == "cut" or event.command == "motion"))
        )
        for event in day.day.happenings
    )
