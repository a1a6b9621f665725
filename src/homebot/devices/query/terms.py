"""Terms of a query: a tree. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypeAlias

from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.support.folding import fold

Operator: TypeAlias = Literal["=", "!=", "<", "<=", ">", ">="]

FIELDS: Mapping[str, str] = MappingProxyType(
    {
        "gateway": "gateway",
        "area": "area",
        "room": "area",
        "floor": "area",
        "type": "type",
        "freshness": "freshness",
        "reachable": "reachable",
        "can": "can",
        "has": "has",
        "id": "id",
        "name": "name",
        "alias": "name",
        "tag": "tag",
        "convention": "convention",
        "category": "category",
        "manufacturer": "manufacturer",
        "vendor": "manufacturer",
        "brand": "manufacturer",
        "model": "model",
        "text": "text",
    }
)
"""Words of ``word=value``, besides capabilities and facts."""


@dataclass(frozen=True, slots=True)
class TypeIs:
    """A device or part of one of these types.

    Attributes:
        word: The word of the query, folded; a device announced with exactly this word matches too.
        tag: The declared kind of an opening: a door is not a window; empty for any.
        by_word: Whether announced words count in addition to the types.
    """

    word: str
    types: frozenset[str]
    tag: str = ""
    by_word: bool = True


@dataclass(frozen=True, slots=True)
class CanDo:
    """A device or part with the capability *name*, which must be settable if *settable*."""

    name: str
    settable: bool = False


@dataclass(frozen=True, slots=True)
class TextTerm:
    """A term with one text. Its subclasses have no own fields, because creating a dataclass takes 0.4 ms."""

    text: str


class InArea(TextTerm):
    """A device in this room, or in a room of this floor or home, folded; a name that begins with it counts too."""

    __slots__ = ()


class AreaIs(TextTerm):
    """A device in exactly this room, or in a room of this floor or home, folded; empty for a device without a room."""

    __slots__ = ()


class NameIs(TextTerm):
    """A device or part with this name or id, folded."""

    __slots__ = ()


class PartIs(TextTerm):
    """A part with this name, folded, which is the word of another type than its own, or its device."""

    __slots__ = ()


class HasText(TextTerm):
    """A device with this word, folded; a search also finds words that begin with it or are a typo away."""

    __slots__ = ()


class FreshnessIs(TextTerm):
    """A device that is ``fresh``, ``unconfirmed`` or ``stale``."""

    __slots__ = ()


class ReachableIs(TextTerm):
    """A device or part with this reachability: ``yes``, ``no`` or ``unknown``."""

    __slots__ = ()


class GatewayIs(TextTerm):
    """A device of this gateway."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class StateIs:
    """A part that reported such a value; an unknown value matches nothing.

    Attributes:
        value: The value to compare with; texts are folded.
        types: The allowed types of the part; empty for any.
        part: The name of the part, as of :class:`PartIs`; empty for any.
    """

    capability: str
    operator: Operator
    value: PlainValue
    types: frozenset[str] = frozenset()
    part: str = ""


@dataclass(frozen=True, slots=True)
class FactIs:
    """A device with this fact, or with a fact that begins with it, folded.

    ``id``, ``name``, ``convention``, ``tag`` and the ``category`` of its parts count as facts. A tag, convention or
    category must be the whole value.
    """

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class IsDisputed:
    """A device whose announcements contradict each other, or whose topics another device claims."""


@dataclass(frozen=True, slots=True)
class IsUnapproved:
    """A dangerous device that the owner has not approved; see :mod:`homebot.devices.always_ask`."""


@dataclass(frozen=True, slots=True)
class IsNear:
    """A device near a robot, best first. Only the directory can check it; elsewhere it always matches.

    Attributes:
        robot: The name of the robot; ``robot`` also means the only robot.
        within: The longest way there, in metres; infinite for any.
    """

    robot: str
    within: float = math.inf


@dataclass(frozen=True, slots=True)
class _Joined:
    """A term that combines others; its class determines how many must match."""

    terms: tuple[Query, ...]


class And(_Joined):
    """All of the terms; without terms, everything matches."""

    __slots__ = ()


class Or(_Joined):
    """Any of the terms."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Not:
    """Everything that the term does not match."""

    term: Query


Query: TypeAlias = (
    TypeIs
    | CanDo
    | AreaIs
    | InArea
    | NameIs
    | PartIs
    | StateIs
    | HasText
    | FreshnessIs
    | ReachableIs
    | GatewayIs
    | FactIs
    | IsDisputed
    | IsUnapproved
    | IsNear
    | And
    | Or
    | Not
)

Exists: TypeAlias = Callable[[Query], bool]
"""Returns whether a device of the house matches a query."""

OPENING_TAGS = {
    "window": frozenset({"", "opening", "window", "skylight"}),
    "door": frozenset({"", "opening", "door", "garage_door", "garage", "gate"}),
    "garage door": frozenset({"", "opening", "garage_door", "garage"}),
    "gate": frozenset({"", "opening", "gate"}),
    "damper": frozenset({"", "damper"}),
}
"""The declared kind of opening for each query word."""

_SENSORS = frozenset(
    name for name in DEVICE_TYPES if name.endswith(("sensor", "detector", "_meter")) or name == "smoke_co_alarm"
)


def type_is(word: str) -> TypeIs:
    """Return the term for a type word such as ``lamps``; any other word must be announced literally."""
    spelled = fold(word)
    exact = word if word in DEVICE_TYPES else ""
    types = frozenset({exact}) if exact else wanted_types(word)
    if spelled in {"sensor", "sensors"}:
        types = _SENSORS
    singular = spelled.removesuffix("s")
    return TypeIs(spelled, types, singular if singular in OPENING_TAGS and not exact else "")


def leaves(query: Query) -> Iterator[Query]:
    """Yield the terms of *query* that join no others."""
    match query:
        case And(terms) | Or(terms):
            for term in terms:
                yield from leaves(term)
        case Not(term):
            yield from leaves(term)
        case _:
            yield query


def lasting(query: Query) -> Query:
    """Return the query for the devices that may ever match *query*: those that have its states at all."""
    match query:
        case And(terms) | Or(terms):
            return type(query)(tuple(map(lasting, terms)))
        case StateIs():
            return CanDo(query.capability)
        case Not() | FreshnessIs() | ReachableIs() | IsDisputed() | IsUnapproved():
            return And(())
        case _:
            return query


def split_near(query: Query) -> tuple[IsNear | None, Query]:
    """Split off the term of *query* to be near a robot, None if there is none; return it and the rest.

    Raises:
        UsageError: It is combined with ``or`` or ``not``, or there are several.
    """
    terms = tuple(_join(query))
    rest = tuple(term for term in terms if not isinstance(term, IsNear))
    if any(isinstance(leaf, IsNear) for term in rest for leaf in leaves(term)):
        remedy = "write for example '(lamp or plug) near robot'"
        raise UsageError(f"'near' applies to a whole query, not to a part with 'or' or 'not'; {remedy}")
    near = [term for term in terms if isinstance(term, IsNear)]
    if len(near) > 1:
        raise UsageError("the query has 'near' twice; one robot and one distance is the limit")
    return (near[0], And(rest)) if near else (None, query)


def _join(query: Query) -> Iterator[Query]:
    """Yield the terms all of which must match."""
    for term in query.terms if isinstance(query, And) else ():
        yield from _join(term)
    if not isinstance(query, And):
        yield query
