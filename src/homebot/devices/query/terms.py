"""Terms of a query, and their test against a device. Pure values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.query.facets import Facets, PartFacets
from homebot.devices.query.folding import fold, is_typo
from homebot.devices.value import PlainValue

__all__ = [
    "And",
    "AreaIs",
    "CanDo",
    "FactIs",
    "FreshnessIs",
    "GatewayIs",
    "HasText",
    "InArea",
    "IsDisputed",
    "NameIs",
    "Not",
    "Operator",
    "Or",
    "Query",
    "ReachableIs",
    "StateIs",
    "TypeIs",
    "compares",
    "fits",
    "type_is",
    "word_fits",
]

Operator: TypeAlias = Literal["=", "!=", "<", "<=", ">", ">="]


@dataclass(frozen=True, slots=True)
class TypeIs:
    """It offers one of these types.

    Attributes:
        word: As it was asked for, folded; a device that was announced with this very word fits as well.
        types: The device types that it means.
        tag: Openings of another declared kind do not fit: a door is no window; empty where that does not matter.
        by_word: Whether announced words count, rather than the types alone.
    """

    word: str
    types: frozenset[str]
    tag: str = ""
    by_word: bool = True

    def wants(self, kind: tuple[str, str]) -> bool:
        """Return whether a part of the type and tag *kind* fits."""
        service_type, tag = kind
        if service_type not in self.types:
            return False
        return not self.tag or service_type not in _OPENINGS or tag in _TAGS[self.tag]


@dataclass(frozen=True, slots=True)
class CanDo:
    """It has the capability *name*; with *settable* it can also be told."""

    name: str
    settable: bool = False


@dataclass(frozen=True, slots=True)
class InArea:
    """It is in this room, folded; a room whose name begins with it fits as well."""

    area: str


@dataclass(frozen=True, slots=True)
class AreaIs:
    """It is in this very room, folded."""

    area: str


@dataclass(frozen=True, slots=True)
class NameIs:
    """It, or its part, has this name or id, folded."""

    name: str


@dataclass(frozen=True, slots=True)
class StateIs:
    """A part told such a value; an unknown value fits nothing.

    Attributes:
        capability: Whose value.
        operator: How it is compared.
        value: With what; texts folded.
        types: The part is of one of these types; empty for any.
    """

    capability: str
    operator: Operator
    value: PlainValue
    types: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class HasText:
    """One of its words is this one, folded, or begins with it, or is a typo away."""

    word: str


@dataclass(frozen=True, slots=True)
class FreshnessIs:
    """It is ``fresh``, ``unconfirmed`` or ``stale``."""

    freshness: str


@dataclass(frozen=True, slots=True)
class ReachableIs:
    """It can be reached: ``yes``, ``no`` or ``unknown``."""

    state: str


@dataclass(frozen=True, slots=True)
class GatewayIs:
    """This gateway hears it."""

    gateway: str


@dataclass(frozen=True, slots=True)
class FactIs:
    """A fact, its ``id``, its ``name`` or its ``convention`` is this, or begins with it, folded.

    One of its parts is of the ``category`` ``config`` or ``diagnostic``.
    """

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class IsDisputed:
    """Others say something else of it, or command what is its own."""


@dataclass(frozen=True, slots=True)
class And:
    """All of it; nothing fits everything."""

    terms: tuple[Query, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """Any of it."""

    terms: tuple[Query, ...]


@dataclass(frozen=True, slots=True)
class Not:
    """Anything but that."""

    term: Query


Query: TypeAlias = (
    TypeIs
    | CanDo
    | AreaIs
    | InArea
    | NameIs
    | StateIs
    | HasText
    | FreshnessIs
    | ReachableIs
    | GatewayIs
    | FactIs
    | IsDisputed
    | And
    | Or
    | Not
)

_OPENINGS = frozenset({"closure", "contact_sensor"})
_TAGS = {
    "window": frozenset({"", "opening", "window", "skylight"}),
    "door": frozenset({"", "opening", "door", "garage_door", "garage", "gate"}),
    "garage door": frozenset({"", "opening", "garage_door", "garage"}),
    "gate": frozenset({"", "opening", "gate"}),
    "damper": frozenset({"", "damper"}),
}
_SENSORS = frozenset(
    name for name in DEVICE_TYPES if name.endswith(("sensor", "detector", "_meter")) or name == "smoke_co_alarm"
)


def type_is(word: str) -> TypeIs:
    """Return the term for a word of a type, such as ``lamps``; any other word must be announced as it is."""
    spelled = fold(word)
    exact = word if word in DEVICE_TYPES else ""
    types = frozenset({exact}) if exact else wanted_types(word)
    if spelled in {"sensor", "sensors"}:
        types = _SENSORS
    singular = spelled.removesuffix("s")
    return TypeIs(spelled, types, singular if singular in _TAGS and not exact else "")


def fits(query: Query, device: Facets | PartFacets) -> bool:
    """Return whether *device*, or one part of it, fits *query*."""
    match query:
        case And(terms):
            fits_all = True
            for term in terms:  # no generator: handles are looked at with every state
                fits_all = fits_all and fits(term, device)
            return fits_all
        case Or(terms):
            return any(fits(term, device) for term in terms)
        case Not(term):
            return not fits(term, device)
        case TypeIs():
            return (
                (query.by_word and query.word in device.words_said)
                or True in map(query.wants, device.kinds)
                or (bool(device.senses) and device.senses == query.types)
            )
        case CanDo(name, settable):
            return name in (device.settable if settable else device.capabilities)
        case StateIs():
            return any(
                capability == query.capability
                and (not query.types or service_type in query.types)
                and compares(query, value)
                for service_type, capability, value in device.values
            )
        case AreaIs(area):
            return device.area == area
        case HasText(word):
            return any(word_fits(word, one) for one in device.words)
        case _:
            return _fits_whole(query, device)


def _fits_whole(
    query: InArea | NameIs | FreshnessIs | ReachableIs | GatewayIs | FactIs | IsDisputed,
    device: Facets | PartFacets,
) -> bool:
    match query:
        case IsDisputed():
            return device.is_disputed
        case NameIs(name):
            return name in device.names
        case InArea(area):
            return bool(device.area) and _begins(device.area, area)
        case FreshnessIs(freshness):
            return device.freshness == freshness
        case ReachableIs(state):
            return device.reachable == state
        case GatewayIs(gateway):
            return gateway in device.gateways
        case FactIs(name, value):
            return _fits_fact(name, value, device)


def _fits_fact(name: str, value: str, device: Facets | PartFacets) -> bool:
    match name:
        case "id":
            return device.id.casefold() == value
        case "name" if _begins(device.name, value):
            return True
        case "convention":
            return value in device.conventions
        case "category":
            return value in device.categories
        case _:
            return any(_begins(fact, value) for fact in device.facts.get(name, ()))


def compares(term: StateIs, value: PlainValue) -> bool:
    """Return whether *value* is as *term* wants it."""
    wanted = term.value
    if value is None:
        return False
    if isinstance(value, str) and isinstance(wanted, str):
        return (fold(value) == wanted) == (term.operator == "=")
    if isinstance(value, bool) or isinstance(wanted, bool):
        return isinstance(value, bool) and isinstance(wanted, bool) and (value is wanted) == (term.operator == "=")
    if not isinstance(value, float) or not isinstance(wanted, float):
        return False
    match term.operator:
        case "=":
            return value == wanted
        case "!=":
            return value != wanted
        case "<":
            return value < wanted
        case "<=":
            return value <= wanted
        case ">":
            return value > wanted
        case ">=":
            return value >= wanted


def word_fits(wanted: str, word: str) -> bool:
    """Return whether a device's *word* is the *wanted* one, begins with it, or is a typo away."""
    return word.startswith(wanted) or is_typo(wanted, word)


def _begins(text: str, wanted: str) -> bool:
    return text == wanted or text.startswith(f"{wanted} ")
