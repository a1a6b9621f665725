"""Patterns of commands, such as ``turn off lights in hall``: a verb, and a query for the devices. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Protocol, TypeAlias, TypeVar, final

from pydantic import AfterValidator, GetCoreSchemaHandler, PlainSerializer, PlainValidator
from pydantic_core import CoreSchema, core_schema

from homebot.config import value_errors
from homebot.devices import Device, DevicePart
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import Query, type_is
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import POWERS
from homebot.errors import UsageError
from homebot.support.names import did_you_mean
from homebot.words.exact_queries import parse_cautious_query, parse_exact_query

_Does: TypeAlias = Callable[[str, PlainValue, PlainValue], bool]
"""Returns whether setting a capability to a value is the action, given the value before, or None if it is unknown."""


class CommandToPart(Protocol):
    """A command that a pattern may match, with its values by capability."""

    @property
    def device(self) -> Device: ...  # noqa: D102 - as of the command
    @property
    def part(self) -> DevicePart: ...  # noqa: D102 - as above
    @property
    def settings(self) -> Mapping[str, PlainValue]: ...  # noqa: D102 - as above


CommandT = TypeVar("CommandT", bound=CommandToPart)
CommandT_contra = TypeVar("CommandT_contra", bound=CommandToPart, contravariant=True)


class CertainValues(Protocol[CommandT_contra]):
    """The certain values of a house."""

    def certain(self, command: CommandT_contra, capability: str, /) -> PlainValue:
        """Return the value of *capability* of the commanded part; None unless it is certain."""


@final
@dataclass(frozen=True, slots=True)
class CommandPattern:
    """Pattern of commands.

    Attributes:
        verb: One of :data:`VERBS`.
    """

    text: str
    verb: str
    query: Query

    def fits(self, command: CommandT, facts: CertainValues[CommandT]) -> bool:
        """Return whether *command* matches, or may match: a motor at an unknown position may be closed."""
        does = VERBS[self.verb]
        for capability, value in command.settings.items():
            known = facts.certain(command, capability) if capability in _COMPARED else None
            if does(capability, value, known):
                return fits(self.query, PartFacets(command.device, command.part))
        return False

    def __str__(self) -> str:
        return self.text

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Accept only instances; otherwise pydantic would build validators for all kinds of queries."""
        return core_schema.is_instance_schema(cls)


def read_pattern(text: str) -> CommandPattern:
    """Parse a verb and a query; without a query the pattern matches every device.

    Raises:
        UsageError: It does not begin with a verb, or the rest is not a query; names the problem.
    """
    words = text.split()
    for length in (2, 1):
        verb = " ".join(words[:length]).casefold()
        if verb in VERBS:
            return CommandPattern(text, verb, _query(text, " ".join(words[length:])))
    known = f"it begins with one of {', '.join(VERBS)}"
    raise UsageError(f"{text[:80]!r} is not a command; {did_you_mean(words[0] if words else '', VERBS, known)}")


def _query(pattern: str, text: str) -> Query:
    try:
        parse_exact_query(text)
        return parse_cautious_query(text)
    except UsageError as exc:
        raise UsageError(f"{pattern[:80]!r}: {exc}") from exc


def pattern_of_type(verb: str, word: str) -> CommandPattern:
    """Return the pattern of *verb* and devices of the type *word*."""
    return CommandPattern(f"{verb} {word}", verb, type_is(word))


def _validate(value: object) -> tuple[CommandPattern, ...]:
    if not isinstance(value, list | tuple) or len(value) > _MAX_PATTERNS:
        raise ValueError(f"must be an array of at most {_MAX_PATTERNS} texts such as 'turn off lights', got {value!r}")
    return tuple(one if isinstance(one, CommandPattern) else _read(one) for one in value)


def _read(value: object) -> CommandPattern:
    with value_errors():
        return read_pattern(value if isinstance(value, str) else repr(value))


def _texts(patterns: tuple[CommandPattern, ...]) -> list[str]:
    return [one.text for one in patterns]


Patterns: TypeAlias = Annotated[
    tuple[CommandPattern, ...], PlainValidator(_validate), PlainSerializer(_texts, return_type=list[str])
]
"""Patterns in a table of the configuration: an array of texts."""


def _query_text(text: str) -> str:
    if not text.strip():
        raise ValueError("must be a query such as 'open contact sensor'")
    with value_errors():
        _query(text, text)
    return text


QueryText: TypeAlias = Annotated[str, AfterValidator(_query_text)]
"""A query as text."""

_MAX_PATTERNS = 100
_MODES = frozenset({"thermostat_mode", "water_heater_mode", "humidifier_mode", "fan_mode"})
_OPENINGS = frozenset({"movement", "valve"})
_COMPARED = frozenset({"position", "heating_setpoint"})
"""Capabilities with an effect that depends on the value before."""

_OPEN, _CLOSED = 100.0, 0.0  # percent
_NO_HEAT = frozenset({"off", "cool", "dry", "fan_only"})


def _turns_on(capability: str, wanted: PlainValue, _known: PlainValue) -> bool:
    return bool(wanted) if capability in POWERS else capability in _MODES and wanted != "off"


def _turns_off(capability: str, wanted: PlainValue, _known: PlainValue) -> bool:
    return wanted == 0 if capability in POWERS else capability in _MODES and wanted == "off"


def _opens(capability: str, wanted: PlainValue, known: PlainValue) -> bool:
    if capability == "position" and isinstance(wanted, float):
        return wanted == _OPEN or wanted > (known if isinstance(known, float) else _CLOSED)
    return (capability in _OPENINGS or capability == "lock") and wanted == "open"


def _closes(capability: str, wanted: PlainValue, known: PlainValue) -> bool:
    if capability == "position" and isinstance(wanted, float):
        return wanted == _CLOSED or wanted < (known if isinstance(known, float) else _OPEN)
    return capability in _OPENINGS and wanted == "closed"


def _heats(capability: str, wanted: PlainValue, known: PlainValue) -> bool:
    """Return whether a command asks for heat: a lower setpoint does not."""
    if capability == "heating_setpoint" and isinstance(wanted, float):
        return not isinstance(known, float) or wanted > known
    return capability in _MODES and wanted not in _NO_HEAT


def _starts(capability: str, wanted: PlainValue, known: PlainValue) -> bool:
    is_work = (capability, wanted) in {("vacuum", "cleaning"), ("vacuum", "spot"), ("mower", "mowing")}
    return is_work or _turns_on(capability, wanted, known)


VERBS: Mapping[str, _Does] = MappingProxyType(
    {
        "turn on": _turns_on,
        "turn off": _turns_off,
        "open": _opens,
        "close": _closes,
        "lock": lambda capability, wanted, _: capability == "lock" and wanted == "locked",
        "unlock": lambda capability, wanted, _: capability == "lock" and wanted in {"unlocked", "open"},
        "disarm": lambda capability, wanted, _: capability == "alarm" and wanted == "disarmed",
        "heat": _heats,
        "start": _starts,
        "use": lambda _capability, _wanted, _known: True,
    }
)
"""The verbs; ``use`` is any command."""
