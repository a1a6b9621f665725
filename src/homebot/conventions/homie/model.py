"""A device as Homie describes it, whatever the version, with the formats of its properties. Pure values.

Source: Homie convention 5, Payload and Property Formats, Device Lifecycle; Homie 4.0, Property Attributes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability
from homebot.conventions.payload import shown
from homebot.errors import WireError
from homebot.numbers import to_number

__all__ = [
    "COLOR_FORMS",
    "DATATYPES",
    "MAX_PROPERTIES",
    "STATES",
    "HomieDevice",
    "HomieNode",
    "HomieProperty",
    "Range",
    "availability_of",
    "parse_options",
    "parse_range",
]


DATATYPES = frozenset({"integer", "float", "boolean", "string", "enum", "color", "datetime", "duration", "json"})
"""Every datatype of versions 3 to 5."""

COLOR_FORMS = ("hsv", "rgb", "xyz")
"""The forms of a colour, the one that loses least first."""

_MAX_OPTIONS = 200
"""Words that an enum may have."""

_LONGEST_OPTION = 255
_FIELDS = 3


@dataclass(frozen=True, slots=True)
class Range:
    """A range of numbers that a property takes.

    Attributes:
        least: Smallest; None where there is none.
        most: Largest; None where there is none.
        step: Distance of the numbers it takes; None for all between.
    """

    least: float | None = None
    most: float | None = None
    step: float | None = None

    def holds(self, number: float) -> bool:
        """Return whether *number* lies within."""
        return (self.least is None or number >= self.least) and (self.most is None or number <= self.most)

    def kept(self, number: float) -> float:
        """Return *number*, or the end that it lies beyond."""
        number = number if self.least is None else max(number, self.least)
        return number if self.most is None else min(number, self.most)

    def nearest(self, number: float) -> float:
        """Return the number that it takes nearest to *number*; steps count from the smallest, or else the largest."""
        if not self.step:
            return number
        base = self.least if self.least is not None else self.most if self.most is not None else 0.0
        steps = math.floor((number - base) / self.step + 0.5)
        nearest = round(base + steps * self.step, 9)
        return nearest if self.most is None or nearest <= self.most else round(nearest - self.step, 9)


def parse_range(text: str) -> Range:
    """Return the range that *text* spells: ``[least]:[most]`` and perhaps ``:step``; empty for any number.

    Raises:
        WireError: It spells none, or one that contains no number.
    """
    if not text:
        return Range()
    fields = text.split(":")
    numbers = [to_number(one) if one else None for one in fields]
    is_spelled = 1 < len(fields) <= _FIELDS and all(
        number is not None or not one for number, one in zip(numbers, fields, strict=True)
    )
    found = Range(*numbers) if is_spelled else None
    if found is None or (found.step is not None and found.step <= 0):
        raise WireError(f"format {shown(text)} is not a range")
    if found.least is not None and found.most is not None and found.least > found.most:
        raise WireError(f"format {shown(text)} contains no number")
    return found


def parse_options(text: str) -> tuple[str, ...]:
    """Return the options of an enum; blanks count.

    Raises:
        WireError: There is none, an empty one, one twice, too many, or one too long.
    """
    options = tuple(text.split(",", _MAX_OPTIONS + 1))
    if len(options) > _MAX_OPTIONS or not all(0 < len(one) <= _LONGEST_OPTION for one in options):
        raise WireError(f"format {shown(text)} is not a list of values")
    if len(set(options)) != len(options):
        raise WireError(f"format {shown(text)} repeats a value")
    return options


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
        topic: Where it is reported; commands go to ``<topic>/set``.
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


STATES: Mapping[str, bool | None] = {
    "init": None,
    "ready": True,
    "sleeping": True,
    "alert": True,
    "disconnected": False,
    "lost": False,
}
"""Reachability of a device by its state; a sleeping one takes commands when it wakes, one that starts means neither."""


@dataclass(frozen=True, slots=True)
class _StateTopic:
    """See :class:`homebot.conventions.description.AvailabilitySource`.

    Attributes:
        topic: The topic.
    """

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device can be reached, or None when *payload* means neither."""
        return STATES.get(payload.decode(errors="replace")) if len(payload) <= _LONGEST else None


_LONGEST = max(map(len, STATES))


def availability_of(topic: str, root: str) -> Availability:
    """Return how the device at *topic* reports whether it can be reached. One whose root is lost is lost.

    Args:
        topic: What its topics begin with.
        root: What those of its root begin with; empty where it has none.
    """
    return Availability(tuple(_StateTopic(f"{one}/$state") for one in (topic, root) if one), "all")
