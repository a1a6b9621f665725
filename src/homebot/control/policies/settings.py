"""Settings of the policies: the tables and keys of ``[control]`` for them. Pure."""

from __future__ import annotations

from datetime import time
from typing import Annotated, Literal, TypeAlias
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator

from homebot.control.policies.command_pattern import CommandPattern, Patterns, pattern_of_type
from homebot.control.policies.home_policy import check_tables
from homebot.devices.query import Query
from homebot.devices.query.exact import parse_exact_query
from homebot.devices.query.parse import parse_query
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.units import Seconds

__all__ = [
    "Interlock",
    "PolicySettings",
    "PresenceGuardSettings",
    "QueryText",
    "QuietHours",
    "RateLimitSettings",
]


_LONGEST_REASON = 200


def _annoying() -> tuple[CommandPattern, ...]:
    return (
        *(pattern_of_type("turn off", word) for word in ("light", "plug", "switch")),
        *(pattern_of_type("close", word) for word in ("window_covering", "closure", "water_valve")),
    )


def _as_tuple(value: object) -> object:
    """Return an array as a tuple: pydantic rejects a list in a table that may be ``true`` as well."""
    return tuple(value) if isinstance(value, list) else value


_Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]
_Contacts: TypeAlias = Annotated[tuple[_Name, ...], BeforeValidator(_as_tuple), Field(min_length=1, max_length=50)]


class PresenceGuardSettings(BaseModel):
    """The table ``[control.presence_guard]``.

    Attributes:
        commands: The commands that apps may not give in an occupied room, or one that may be.
        absent_after: Seconds without motion after which a room is empty: a person who reads does not move.
        doors: The ids or names of the contacts on all doors of a room, by its name: a person who moved in it after
            they were closed is there until one opens.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    commands: Patterns = Field(default_factory=_annoying)
    absent_after: Seconds = 1200.0
    doors: Annotated[dict[_Name, _Contacts], Field(max_length=1000)] = Field(default_factory=dict)

    def contacts_of(self, room: str) -> tuple[str, ...]:
        """Return the contacts on all doors of *room*; none if they are not known."""
        if not self.doors:
            return ()
        return next((contacts for name, contacts in self.doors.items() if fold(name) == fold(room)), ())


def _local(value: time) -> time:
    """Return *value* if it is a time of day in the home."""
    if value.tzinfo is not None:
        raise ValueError("must be a local time such as 22:00; `[control] time_zone` says where")
    return value


_LocalTime: TypeAlias = Annotated[time, AfterValidator(_local)]


class QuietHours(BaseModel):
    """A table ``[[control.quiet_hours]]``.

    Attributes:
        start: The local time at which they begin.
        end: The local time at which they end; before *start* it is on the next day.
        commands: The commands that apps may not give meanwhile.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    start: _LocalTime
    end: _LocalTime
    commands: Patterns

    @field_validator("end")
    @classmethod
    def _is_another_time(cls, end: time, info: ValidationInfo) -> time:
        if end == info.data.get("start"):
            raise ValueError(f"is {end:%H:%M} as start is, so that it would never be quiet")
        return end


def _query_text(text: str) -> str:
    """Return *text* if it is a query."""
    if not text.strip():
        raise ValueError("must be a query such as 'open contact sensor'")
    try:
        parse_exact_query(text)
    except UsageError as exc:
        raise ValueError(f"{text[:80]!r}: {exc}") from exc
    return text


QueryText: TypeAlias = Annotated[str, AfterValidator(_query_text)]
"""A query as text."""


class Interlock(BaseModel):
    """A table ``[[control.interlocks]]``.

    Attributes:
        commands: The refused commands.
        condition: The query, written as ``while``: the commands are refused while a device matches.
        where: Whether that device must be in the room of the commanded one, or may be anywhere in the home.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    commands: Patterns
    condition: QueryText = Field(alias="while")
    where: Literal["room", "home"] = "room"

    @property
    def query(self) -> Query:
        """The condition as a query."""
        return parse_query(self.condition)


class RateLimitSettings(BaseModel):
    """The table ``[control.rate_limit]``.

    Attributes:
        changes: The number of turns of a value that are allowed within *seconds*.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    changes: int = Field(default=30, ge=1, le=1000)
    seconds: Seconds = 10.0


def _zone(name: str) -> str:
    """Return *name* if it is a time zone, or empty for that of the computer."""
    if name:
        try:
            ZoneInfo(name)
        except (ZoneInfoNotFoundError, ValueError) as exc:
            raise ValueError(f"{name!r} is no time zone of this computer; write one like 'Europe/Vienna'") from exc
    return name


def _table_or_bool(example: str) -> BeforeValidator:
    """Return a validator: ``true`` is the default table, ``false`` is None; *example* is a table, for messages."""

    def read(value: object) -> object:
        if isinstance(value, bool):
            return {} if value else None
        if value is None or isinstance(value, (dict, BaseModel)):
            return value
        raise ValueError(f"must be true, false or a table such as {example}, got {value!r}"[:_LONGEST_REASON])

    return BeforeValidator(read)


_Guard: TypeAlias = Annotated[PresenceGuardSettings | None, _table_or_bool("{absent_after = 1200}")]
_Rate: TypeAlias = Annotated[RateLimitSettings | None, _table_or_bool("{changes = 30, seconds = 10}")]
_Hours: TypeAlias = Annotated[tuple[QuietHours, ...], Field(max_length=100)]
_Interlocks: TypeAlias = Annotated[tuple[Interlock, ...], Field(max_length=100)]


def _installed(tables: dict[str, dict[str, object]]) -> dict[str, dict[str, object]]:
    """Return *tables* if installed policies accept them."""
    if not tables:
        return tables

    return check_tables(tables)


_Policies: TypeAlias = Annotated[dict[_Name, dict[str, object]], Field(max_length=100), AfterValidator(_installed)]


class PolicySettings(BaseModel):
    """The keys of the table ``[control]`` for policies.

    Attributes:
        presence_guard: Whether apps may not turn things off or close them in an occupied room: ``true``, or a table.
        quiet_hours: Times at which apps may not give some commands.
        interlocks: Commands that are refused while a condition holds.
        rate_limit: The limit for switching to and fro; ``false`` for none.
        always_ask: Whether locks, garage doors, ovens and the like take a right that names them.
        approvals: Whether these take no command until the owner approves each device.
        policies: The tables of the policies of other packages, by the names of their entry points.
        time_zone: The time zone of the home, such as ``Europe/Vienna``; empty for that of the computer.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    presence_guard: _Guard = None
    quiet_hours: _Hours = ()
    interlocks: _Interlocks = ()
    rate_limit: _Rate = RateLimitSettings()
    always_ask: bool = True
    approvals: bool = True
    policies: _Policies = Field(default_factory=dict)
    time_zone: Annotated[str, AfterValidator(_zone)] = ""

    @property
    def needs_house(self) -> bool:
        """True if some policy needs the values of sensors."""
        return self.presence_guard is not None or bool(self.interlocks) or bool(self.policies)
