"""A device as Homie describes it, whatever the version. Pure values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.homie.formats import Range

__all__ = ["MAX_PROPERTIES", "HomieDevice", "HomieNode", "HomieProperty"]

MAX_PROPERTIES = 500
"""Properties of one device that are looked at."""


@dataclass(frozen=True, slots=True)
class HomieProperty:
    """One value of a device.

    Attributes:
        id: Unique in its node.
        name: What people call it.
        datatype: ``integer``, ``float``, ``boolean``, ``string``, ``enum``, ``color``, ``datetime``, ``duration`` or
            ``json``.
        topic: Where it is told; commands go to ``<topic>/set``.
        unit: Of a number; empty where it has none.
        range: Of a number.
        options: Of an enum, or the forms of a colour.
        is_settable: Whether it takes commands.
        is_retained: Whether its value is a state; otherwise it is an event.
        names_form: Whether a colour's form stands before its numbers, as in version 5.
    """

    id: str
    name: str
    datatype: str
    topic: str
    unit: str = ""
    range: Range = field(default_factory=Range)
    options: tuple[str, ...] = ()
    is_settable: bool = False
    is_retained: bool = True
    names_form: bool = True

    @property
    def is_number(self) -> bool:
        """True if its values are numbers."""
        return self.datatype in {"integer", "float"}


@dataclass(frozen=True, slots=True)
class HomieNode:
    """A part of a device, as Homie divides it.

    Attributes:
        id: Unique in its device.
        name: What people call it.
        type: What it calls itself.
        properties: Its values.
    """

    id: str
    name: str
    type: str
    properties: tuple[HomieProperty, ...]


@dataclass(frozen=True, slots=True)
class HomieDevice:
    """A device.

    Attributes:
        id: Unique in its domain.
        name: What people call it.
        type: What it calls itself.
        topic: What all of its topics begin with.
        nodes: What it consists of.
        root: Topic of the device that it hangs on; empty for none.
        facts: Further facts.
    """

    id: str
    name: str
    type: str
    topic: str
    nodes: tuple[HomieNode, ...]
    root: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)
