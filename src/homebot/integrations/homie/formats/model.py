"""Devices, nodes and properties of Homie, of all versions, and the formats of properties. Pure values.

Source: Homie convention 5, Payload and Property Formats, Device Lifecycle; Homie 4.0, Property Attributes.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability
from homebot.conventions.payload import shown
from homebot.errors import WireError
from homebot.support.numbers import to_number

COLOR_FORMS = ("hsv", "rgb", "xyz")
"""The forms of a colour, the one that loses least first."""

PROPERTY_ATTRIBUTES = ("$name", "$format", "$unit", "$settable", "$retained", "$datatype")
NODE_ATTRIBUTES = ("$name", "$type", "$array", "$properties")
DEVICE_ATTRIBUTES = ("$name", "$mac", "$fw/name", "$fw/version", "$implementation", "$nodes", "$homie", "$state")
"""Attributes of versions 3 and 4, each a topic of its own."""

_MAX_OPTIONS = 200
"""Words that an enum may have."""

_MAX_OPTION_CHARACTERS = 255
_FIELDS = 3


@dataclass(frozen=True, slots=True)
class Range:
    """A range of numbers: its bounds and its step, each None if there is none."""

    least: float | None = None
    most: float | None = None
    step: float | None = None

    @property
    def grid(self) -> tuple[float, ...]:
        """The allowed numbers; see :attr:`homebot.devices.part.Capability.grid`."""
        from homebot.conventions.units import number_grid  # noqa: PLC0415 - a start reads no range

        return number_grid(self.most if self.least is None else self.least, self.step)

    def holds(self, number: float) -> bool:
        """Return whether *number* lies within."""
        return (self.least is None or number >= self.least) and (self.most is None or number <= self.most)

    def kept(self, number: float) -> float:
        """Return *number*, or the end that it lies beyond."""
        number = number if self.least is None else max(number, self.least)
        return number if self.most is None else min(number, self.most)

    def nearest(self, number: float) -> float:
        """Return the nearest allowed number; steps count from the smallest, or else from the largest."""
        if not self.step:
            return number
        base, step = self.grid
        nearest = round(base + math.floor((number - base) / step + 0.5) * step, 9)
        return nearest if self.most is None or nearest <= self.most else round(nearest - self.step, 9)


def parse_range(text: str) -> Range:
    """Return the range that *text* spells: ``[least]:[most]`` and perhaps ``:step``; empty for any number.

    Raises:
        WireError: It spells none, or one that contains no number.
    """
    if not text:
        return Range()
    fields = text.split(":")
    numbers = [to_number(field) for field in fields]
    if not 1 < len(fields) <= _FIELDS or any(number is None and fields[i] for i, number in enumerate(numbers)):
        raise WireError(f"format {shown(text)} is not a range")
    least, most, step = (*numbers, None)[:_FIELDS]
    if step is not None and step <= 0:
        raise WireError(f"format {shown(text)} is not a range")
    if least is not None and most is not None and least > most:
        raise WireError(f"format {shown(text)} contains no number")
    return Range(least, most, step)


MAX_PROPERTIES = 500
"""Most properties of one device."""


@dataclass(frozen=True, slots=True)
class HomieProperty:
    """One value of a device.

    Attributes:
        datatype: One of versions 3 to 5, but an enum of two states is a boolean.
        topic: The topic of its value; commands go to ``<topic>/set``.
        options: The options of an enum, or the forms of a colour.
        is_retained: Whether its value is a state; otherwise it is an event.
        names_form: Whether a colour's form stands before its numbers, as in version 5.
        flags: The payloads of a boolean for false and true.
        sign: -1 if a measured number is to be negated.
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
    flags: tuple[str, str] = ("false", "true")
    sign: float = 1.0

    @property
    def is_number(self) -> bool:
        """True if its values are numbers."""
        return self.datatype in {"integer", "float"}


def parse_options(text: str) -> tuple[str, ...]:
    """Return the options of an enum; blanks count.

    Raises:
        WireError: There is none, an empty one, one twice, too many, or one too long.
    """
    options = tuple(text.split(",", _MAX_OPTIONS + 1))
    if len(options) > _MAX_OPTIONS or not all(0 < len(option) <= _MAX_OPTION_CHARACTERS for option in options):
        raise WireError(f"format {shown(text)} is not a list of values")
    if len(set(options)) != len(options):
        raise WireError(f"format {shown(text)} repeats a value")
    return options


@dataclass(frozen=True, slots=True)
class HomieNode:
    """A node of a device; its id is unique there."""

    id: str
    name: str
    type: str
    properties: tuple[HomieProperty, ...]


@dataclass(frozen=True, slots=True)
class HomieDevice:
    """A device.

    Attributes:
        topic: The topic above all its topics.
        root: The topic of its root device; empty for none.
        ignored: Number of its invalid nodes and properties.
    """

    id: str
    name: str
    type: str
    topic: str
    nodes: tuple[HomieNode, ...]
    root: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)
    ignored: int = 0


STATES: Mapping[str, bool | None] = {
    "init": None,
    "ready": True,
    "sleeping": True,
    "alert": True,
    "disconnected": False,
    "lost": False,
}
"""Reachability by state; a sleeping device executes commands when it wakes, a starting one means neither."""


@dataclass(frozen=True, slots=True)
class _StateTopic:
    """The state of a device as an :class:`homebot.conventions.description.AvailabilitySource`."""

    topic: str

    def read(self, payload: bytes) -> bool | None:
        return STATES.get(payload.decode(errors="replace")) if len(payload) <= _MAX_STATE_CHARACTERS else None


_MAX_STATE_CHARACTERS = max(map(len, STATES))


def availability_of(topic: str, root: str) -> Availability:
    """Return the availability of the device at *topic*, which is lost with its *root*, if that is not empty."""
    return Availability(tuple(_StateTopic(f"{device}/$state") for device in (topic, root) if device), "all")
