"""Settings of the control layer and of its policies: the table ``[control]``."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Final, TypeAlias, TypeVar
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from homebot.control.policies.facts import PolicyTable
from homebot.control.policies.home_policy import NamedPolicy, check_tables, home_policies
from homebot.control.policies.interlock import Interlock
from homebot.control.policies.presence_guard import PresenceGuardSettings
from homebot.control.policies.quiet_hours import QuietHours
from homebot.control.policies.rate_limit import RateLimitSettings
from homebot.devices.misspelt_names import StatedNames
from homebot.devices.query.terms import Query
from homebot.support.folding import fold
from homebot.units import Seconds
from homebot.words.exact_queries import parse_lasting_query
from homebot.words.patterns import QueryText

_WITNESSES: Final = "control.witnesses"
_DOORS: Final = "control.presence_guard.doors"


_MAX_REASON_CHARACTERS = 200


def _zone(name: str) -> str:
    """Return *name* if it is a time zone, or empty for the computer's."""
    if name:
        try:
            ZoneInfo(name)
        except (ZoneInfoNotFoundError, ValueError) as exc:
            raise ValueError(f"{name!r} is not a time zone of this computer; write one like 'Europe/Vienna'") from exc
    return name


def _table_or_bool(example: str) -> BeforeValidator:
    """Return a validator: ``true`` is the default table, ``false`` is None; *example* is a table, for messages."""

    def read(value: object) -> object:
        if isinstance(value, bool):
            return {} if value else None
        if value is None or isinstance(value, (dict, BaseModel)):
            return value
        raise ValueError(f"must be true, false or a table such as {example}, got {value!r}"[:_MAX_REASON_CHARACTERS])

    return BeforeValidator(read)


_Guard: TypeAlias = Annotated[PresenceGuardSettings | None, _table_or_bool("{absent_after = 1200}")]
_Rate: TypeAlias = Annotated[RateLimitSettings | None, _table_or_bool("{changes = 30, seconds = 10}")]
_T = TypeVar("_T")
_Tables: TypeAlias = Annotated[tuple[_T, ...], Field(max_length=100)]
_Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]
_Installed: TypeAlias = Annotated[dict[_Name, dict[str, object]], Field(max_length=100), AfterValidator(check_tables)]


class PolicySettings(BaseModel):
    """The keys of the table ``[control]`` for policies, in the order in which these check a command.

    A new policy of homebot is a :class:`PolicyTable` in its own file, plus its key here.

    Attributes:
        interlocks: Commands that are refused while a condition holds.
        quiet_hours: Times at which apps may not give some commands.
        presence_guard: Whether apps may not turn things off or close them in an occupied room: ``true``, or a table.
        policies: The tables of the policies of other packages, by the names of their entry points.
        rate_limit: The limit for switching back and forth; ``false`` for none.
        always_ask: Whether locks, garage doors, ovens and the like need a right that names them.
        approvals: Whether these devices take no command until the owner approves them.
        time_zone: The time zone, such as ``Europe/Vienna``; empty for that of ``[home]``, or else the computer's.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    interlocks: _Tables[Interlock] = ()
    quiet_hours: _Tables[QuietHours] = ()
    presence_guard: _Guard = None
    policies: _Installed = Field(default_factory=dict)
    rate_limit: _Rate = RateLimitSettings()
    always_ask: bool = True
    approvals: bool = True
    time_zone: Annotated[str, AfterValidator(_zone)] = ""

    def tables(self) -> Iterator[PolicyTable | NamedPolicy]:
        """Yield all policies except those of rights, in their order."""
        for key in PolicySettings.model_fields:
            value: object = getattr(self, key)
            if key == "policies":
                yield from home_policies(self.policies)
            for policy in value if isinstance(value, tuple) else (value,):
                if isinstance(policy, PolicyTable):
                    yield policy

    @property
    def needs_house(self) -> bool:
        """True if some policy needs the values of sensors."""
        return bool(self.policies) or any(table.needs is not None for table in self.tables())


class ControlSettings(PolicySettings):
    """The table ``[control]``, including the keys of the policies.

    Attributes:
        timeout: Seconds that a device has to answer; longer if it usually takes longer, and at least a minute for
            blinds and other motors.
        retries: The number of repetitions of a command without an answer; a press is never repeated.
        witnesses: For each query, the id or name of the sensor that observes the devices that fit it; empty for none.
        settle: Seconds after a confirmed command during which a device that goes back is reported as reverted.
        hand_time: Seconds for which a person's hand outranks a lease.
        journal_days: Days for which the journal stores entries.
        journal_megabytes: The largest size of the journal's file; the oldest entries are dropped first.
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
        """The named sensors, case-folded, each with its query."""
        return tuple((parse_lasting_query(query), fold(name)) for query, name in self.witnesses.items())

    @property
    def stated_names(self) -> StatedNames:
        """The sensors, contacts, rooms, queries and commands in the table, any of which may be misspelt."""
        doors = self.presence_guard.doors if self.presence_guard is not None else {}
        contacts = [(f"{_DOORS}.{room}", contact) for room, named in doors.items() for contact in named]
        sensors = [(f"{_WITNESSES}.{query!r}", sensor) for query, sensor in self.witnesses.items() if sensor.strip()]
        return StatedNames(
            rooms=[(_DOORS, room) for room in doors],
            devices=[*contacts, *sensors],
            queries=[(_WITNESSES, query, parse_lasting_query(query)) for query in self.witnesses],
            patterns=[*_stated("interlocks", self.interlocks), *_stated("quiet_hours", self.quiet_hours)],
        )


def _stated(key: str, tables: Iterable[Interlock | QuietHours]) -> Iterator[tuple[str, str, Query]]:
    """Yield the key, the text and the query of each command in *tables*."""
    for table in tables:
        for pattern in table.commands:
            yield f"control.{key}", pattern.text, pattern.query
