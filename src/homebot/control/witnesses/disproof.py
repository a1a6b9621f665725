"""Parts that a witness saw not to be as they report, and their records in the journal's store. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Final, TypeAlias

from pydantic import Field

from homebot.control.learnt_record import LearntRecord
from homebot.control.witnesses.activity import Place
from homebot.control.witnesses.command_watch import CommandWatch

__all__ = ["Disproof", "disproof_name", "disproof_record", "read_disproof"]

_LONGEST: Final = 1000
_HALF: Final = 50.0

_SPACING: Final = 60.0
"""Seconds between two commands at least, that both count: a person repeats at once what did not work."""

_Text: TypeAlias = Annotated[str, Field(max_length=_LONGEST)]
_Sensor: TypeAlias = tuple[str, str, str]


@dataclass(slots=True, eq=False)
class Disproof:
    """A part that reported what a witness did not see.

    Attributes:
        before: How strong the part is, by what the witness saw, 0 to 100.
        sensor: The ids of the witness and of its part, and its capability.
        name: The name of the witness.
        counted_at: When the last command was disbelieved that counts, in seconds since the Unix epoch.
        unheard: Commands in a row that were disbelieved, at least a minute apart, without any report of the witness.
        watch: The command that was contradicted, as it was watched; None in a later run.
        reported: The capabilities that the part reported in this run.
        commanded_at: When a command of this run was last given or over, in seconds of the monotonic clock.
    """

    before: float
    sensor: _Sensor
    name: str
    counted_at: float
    unheard: int = 0
    watch: CommandWatch | None = None
    reported: set[str] = field(default_factory=set)
    commanded_at: float = -math.inf

    def covers(self, strength: float | None) -> bool:
        """Return whether a report of *strength*, 0 to 100, is what the witness did not see."""
        if strength is None:
            return False
        return strength > self.before if self.before < _HALF else strength < self.before

    def count(self, now: float, *, is_heard: bool) -> None:
        """Note that one more command is disbelieved; *is_heard* is whether the witness reported since the last one."""
        if is_heard:
            self.unheard, self.counted_at = 0, now
        elif now - self.counted_at >= _SPACING:
            self.unheard, self.counted_at = self.unheard + 1, now


class _KeptDisproof(LearntRecord):
    title = "contradiction of a device"

    device: _Text
    part: _Text
    before: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)]
    sensor: _Sensor
    name: _Text
    counted_at: Annotated[float, Field(allow_inf_nan=False)]
    unheard: Annotated[int, Field(ge=0)]

    @property
    def kept_as(self) -> str:
        return disproof_name((self.device, self.part))


def disproof_name(place: Place) -> str:
    """Return the name of the record of a part."""
    return " ".join(place)


def disproof_record(place: Place, disproof: Disproof) -> str:
    """Return what an earlier run's *disproof* of a part is read from."""
    device, part = place
    return _KeptDisproof(
        device=device,
        part=part,
        before=disproof.before,
        sensor=disproof.sensor,
        name=disproof.name,
        counted_at=disproof.counted_at,
        unheard=disproof.unheard,
    ).model_dump_json()


def read_disproof(name: str, record: str) -> tuple[Place, Disproof]:
    """Return what :func:`disproof_record` made the text of.

    Raises:
        WireError: It is no such text, of another version, or of another part than *name*.
    """
    row = _KeptDisproof.read(name, record)
    return (row.device, row.part), Disproof(row.before, row.sensor, row.name, row.counted_at, row.unheard)
