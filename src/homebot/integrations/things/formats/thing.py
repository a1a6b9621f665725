"""Validated W3C Thing Descriptions: the affordances of a thing, and their forms.

Source: W3C Recommendation "Web of Things (WoT) Thing Description 1.1", section 5; the terms ``mqv:`` are those of the
editor's draft "Web of Things (WoT) MQTT Binding".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, Literal, TypeAlias, get_args

from homebot.conventions.payload import clean_text
from homebot.devices.identity import identifiers

AffordanceKind: TypeAlias = Literal["property", "action", "event"]
DataType: TypeAlias = Literal["boolean", "integer", "number", "string", "object", "array", "null", ""]

ThingChange: TypeAlias = Literal["thing_created", "thing_updated", "thing_deleted"]
"""The kinds of events of a directory of things."""

THING_CHANGES: Final[tuple[ThingChange, ...]] = get_args(ThingChange)

OBSERVE_OPS = frozenset({"readproperty", "observeproperty", "subscribeevent"})
"""Operations that return values."""

WRITE_OPS = frozenset({"writeproperty", "invokeaction"})

NO_SECURITY: Mapping[str, object] = {"securityDefinitions": {"nosec_sc": {"scheme": "nosec"}}, "security": "nosec_sc"}
"""The members of a description without security."""

_OWN = ("mac:", "eui64:", "id:")


@dataclass(frozen=True, slots=True)
class Form:
    """One way to use an affordance.

    Attributes:
        ops: Its operations, for example ``writeproperty``; at least one.
        scheme: Of its address, for example ``mqtt``; empty if only a relative address was given.
        href: Its address, absolute if the description has a base; contains ``{`` if variables need a value.
        subprotocol: How values are pushed, for example ``sse``; empty for the protocol's own way.
        method: Of the request, for example ``PUT``; empty for the protocol's own choice.
        security: The names of the security schemes that it requires, all of them.
        topic: Topic for publishing; empty for none.
        filter: Filter for subscribing; empty for none.
        qos: 0 to 2.
        content_type: Encoding of payloads; ``application/json`` if none is declared.
        response_type: Encoding of answers, if different; otherwise empty.
    """

    ops: tuple[str, ...]
    scheme: str
    href: str = ""
    subprotocol: str = ""
    method: str = ""
    security: tuple[str, ...] = ()
    topic: str = ""
    filter: str = ""
    qos: int = 0
    retain: bool = False
    content_type: str = "application/json"
    response_type: str = ""

    @property
    def is_mqtt(self) -> bool:
        """True for MQTT."""
        return self.scheme in {"mqtt", "mqtts", "ws+mqtt"} or bool(self.topic or self.filter)


@dataclass(frozen=True, slots=True)
class DataSchema:
    """The constraints on a value.

    Attributes:
        type: Type of the values; empty if not declared.
        unit: Unit in the original spelling; empty for none.
        enum: The allowed values, if listed, without those that are neither texts, numbers nor booleans.
        member: The name of the member of an object that has the value; empty if the value is no object, or is itself
            one. The other fields are those of the member.
        words: Texts that may replace a number, such as ``unmeasurable``; the number is then unknown.
        members: Of an object with several members, the required ones with a single value, by name.
    """

    type: DataType = ""
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    enum: tuple[str | float | bool, ...] = ()
    member: str = ""
    words: tuple[str, ...] = ()
    members: tuple[tuple[str, DataSchema], ...] = ()


@dataclass(frozen=True, slots=True)
class Affordance:
    """Something that can be read, written or observed.

    Attributes:
        name: Unique among its kind in the thing.
        title: Its name for people; empty if unknown.
        types: Its semantic types, without prefix.
        schema: Its possible values: for an action its input, for an event its data.
        forms: The ways to use it, at least one.
        extension: homebot's own terms, by the name after ``homebot:``; only texts.
    """

    name: str
    kind: AffordanceKind
    title: str
    types: tuple[str, ...]
    schema: DataSchema
    read_only: bool
    write_only: bool
    forms: tuple[Form, ...]
    extension: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Thing:
    """A thing.

    Attributes:
        id: Its URI; empty if it has none.
        types: Its semantic types, without prefix.
        affordances: Properties, then actions, then events, each in their order.
        area: Its room; empty if unknown.
        identifiers: Its identifiers; see :func:`homebot.devices.identity.identifiers`.
        security: The ways of authentication that forms name, for example ``nosec`` or ``basic``.
    """

    id: str
    title: str
    types: tuple[str, ...]
    description: str
    affordances: tuple[Affordance, ...]
    facts: Mapping[str, str] = field(default_factory=dict)
    area: str = ""
    identifiers: tuple[str, ...] = ()
    security: Mapping[str, str] = field(default_factory=dict)


def identifiers_of(thing: Thing, *others: str) -> tuple[str, ...]:
    """Return :func:`homebot.devices.identity.identifiers` of *thing*; *others* may include the name of its host."""
    own = tuple(identifier for identifier in thing.identifiers if identifier.startswith(_OWN))
    declared = identifiers(
        identifier for identifier in (*thing.identifiers, thing.id, *others) if identifier and identifier not in own
    )
    return tuple(dict.fromkeys((*own, *declared)))


def facts_of(thing: Thing) -> dict[str, str]:
    """Return the further facts about *thing* in its description, by name."""
    facts = {clean_text(key, 60): clean_text(value) for key, value in thing.facts.items()}
    if thing.description:
        facts.setdefault("description", clean_text(thing.description, 200))
    return facts


def change_forms(thing: Thing, change: Callable[[Form], Form | None]) -> Thing:
    """Return *thing* with forms replaced by *change*, which returns the replacement, or None to remove a form."""
    changed = (
        (affordance, tuple(new for form in affordance.forms if (new := change(form)) is not None))
        for affordance in thing.affordances
    )
    return replace(thing, affordances=tuple(replace(affordance, forms=forms) for affordance, forms in changed))
