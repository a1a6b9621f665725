"""Settings of the control layer."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from homebot.control.policies import PolicySettings
from homebot.control.policies.command_pattern import QueryText
from homebot.devices.misspelt_names import StatedNames
from homebot.devices.query import Query
from homebot.devices.query.exact import parse_lasting_query
from homebot.support.folding import fold
from homebot.units import Seconds

__all__ = ["ControlSettings"]

_WITNESSES: Final = "control.witnesses"
_DOORS: Final = "control.presence_guard.doors"


class ControlSettings(PolicySettings):
    """The table ``[control]``, with that of the policies.

    Attributes:
        timeout: Seconds that a device has for its answer; longer if it usually takes longer, and a minute at least for
            blinds and other motors.
        retries: The number of repetitions of a command without an answer; a press is never repeated.
        witnesses: The sensor, by its id or name, that observes the devices that fit a query; an empty one is none.
        settle: Seconds after a confirmed command in which a device that goes back is reported as reverted.
        hand_time: Seconds for which a person's hand outranks a lease.
        journal_days: Days for which the journal stores entries.
        journal_megabytes: Size of the journal's file at most; the oldest entries are dropped first.
    """

    timeout: Seconds = 10.0
    retries: int = Field(default=2, ge=0, le=10)
    witnesses: Annotated[dict[QueryText, str], Field(max_length=100)] = Field(default_factory=dict)
    settle: Seconds = 10.0
    hand_time: Seconds = 300.0
    journal_days: float = Field(default=30.0, gt=0, le=3660)
    journal_megabytes: float = Field(default=50.0, ge=1, le=10_000)

    @property
    def named_witnesses(self) -> tuple[tuple[Query, str], ...]:
        """The named sensors, folded, each with its query."""
        return tuple((parse_lasting_query(query), fold(name)) for query, name in self.witnesses.items())

    @property
    def stated_names(self) -> StatedNames:
        """The sensors, contacts, rooms and queries in it, which may be misspelt."""
        doors = self.presence_guard.doors if self.presence_guard is not None else {}
        contacts = [(f"{_DOORS}.{room}", contact) for room, named in doors.items() for contact in named]
        sensors = [(f"{_WITNESSES}.{query!r}", sensor) for query, sensor in self.witnesses.items() if sensor.strip()]
        return StatedNames(
            rooms=[(_DOORS, room) for room in doors],
            devices=[*contacts, *sensors],
            queries=[(_WITNESSES, query, parse_lasting_query(query)) for query in self.witnesses],
        )
