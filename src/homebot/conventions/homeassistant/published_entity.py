"""One entity that a Home Assistant shall make of something offered: its config, its states and its commands. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = [
    "Available",
    "CommandReader",
    "EntityTopics",
    "PublishedEntity",
    "PublishedState",
    "StateWriter",
    "Values",
    "flag_text",
    "number_text",
    "read_flag",
    "read_number",
    "read_option",
    "reader_of",
    "shortest",
    "take_choice",
    "take_reported",
    "take_settable",
    "unknown_text",
]

Values: TypeAlias = Mapping[str, PlainValue]
"""The known values of a part, by capability."""

StateWriter: TypeAlias = Callable[[Values], str]
"""The payload of the values; empty for one that clears what the broker keeps."""

CommandReader: TypeAlias = Callable[[str], Values]
"""The values that a payload commands, by capability, in this order; empty for what is no command. Never raises."""

Available: TypeAlias = dict[str, Capability]
"""The capabilities of a part that no entity has taken yet, by name."""


@dataclass(frozen=True, slots=True)
class EntityTopics:
    """The topics of one part that is offered.

    Attributes:
        base: What all of them begin with.
    """

    base: str

    def state(self, name: str) -> str:
        """Return the topic of the state *name*."""
        return f"{self.base}/{name}/state"

    def command(self, name: str) -> str:
        """Return the topic of commands to *name*."""
        return f"{self.base}/{name}/set"


@dataclass(frozen=True, slots=True)
class PublishedState:
    """The state that is published on one topic.

    Attributes:
        topic: The topic.
        capabilities: Whose values it publishes.
        write: Makes the payload of the values.
        is_event: Whether it publishes what happens and is over, which the broker must not keep.
    """

    topic: str
    capabilities: frozenset[str]
    write: StateWriter
    is_event: bool = False


class PublishedEntity:
    """An entity in the making.

    Args:
        topics: Of its part.
        component: What Home Assistant shall make, for example ``light``.
        name: Tells it from the part's other entities; empty for what the part is for.
        config: The fields that name no topic.

    Attributes:
        component: The same.
        name: The same.
        config: All fields of its config so far.
        states: The states that it publishes.
        commands: Readers of its commands, by topic.
    """

    def __init__(
        self, topics: EntityTopics, component: str, name: str, config: Mapping[str, object] | None = None
    ) -> None:
        self.component = component
        self.name = name
        self.config: dict[str, object] = dict(config or {})
        self.states: list[PublishedState] = []
        self.commands: dict[str, CommandReader] = {}
        self._topics = topics

    def add_state(
        self, key: str, name: str, write: StateWriter, capabilities: Iterable[str] = (), *, is_event: bool = False
    ) -> None:
        """Publish *capabilities*, by default *name* alone, on a topic that the field *key* names."""
        topic = self.config[key] = self._topics.state(name)
        self.states.append(PublishedState(topic, frozenset(capabilities) or frozenset({name}), write, is_event))

    def add_command(self, key: str, name: str, read: CommandReader) -> None:
        """Take commands on a topic that the field *key* names."""
        topic = self.config[key] = self._topics.command(name)
        self.commands[topic] = read

    def has(self, capability: Capability, state_key: str, write: StateWriter, command_key: str = "") -> None:
        """Publish *capability* where it is readable; see :meth:`add_state`. A command for it is read by its kind."""
        if capability.readable:
            self.add_state(state_key, capability.name, write)
        if capability.settable and command_key:
            self.add_command(command_key, capability.name, reader_of(capability))


def unknown_text(name: str) -> StateWriter:
    """Return a writer of a text; ``None`` stands for unknown."""

    def write(values: Values) -> str:
        value = values.get(name)
        return value if isinstance(value, str) else "None"

    return write


def flag_text(name: str, on: str = "ON", off: str = "OFF", unknown: str = "None") -> StateWriter:
    """Return a writer of a truth."""

    def write(values: Values) -> str:
        value = values.get(name)
        return unknown if value is None else (on if value else off)

    return write


def number_text(name: str, unknown: str = "None") -> StateWriter:
    """Return a writer of a number."""

    def write(values: Values) -> str:
        value = values.get(name)
        return shortest(value) if isinstance(value, float) else unknown

    return write


def shortest(number: float) -> str:
    """Return *number* without a point where it is whole, and never with fewer digits than it has."""
    return str(int(number)) if number.is_integer() and abs(number) < _WHOLE else repr(number)


def read_flag(name: str, payloads: Mapping[str, bool]) -> CommandReader:
    """Return a reader of commands that are two payloads, or one."""

    def read(text: str) -> Values:
        return {name: payloads[text]} if text in payloads else {}

    return read


def read_number(name: str, bounds: tuple[float, ...]) -> CommandReader:
    """Return a reader of numbers within *bounds*."""
    least, most = bounds or _WIDE

    def read(text: str) -> Values:
        number = to_number(text)
        return {name: number} if number is not None and least <= number <= most else {}

    return read


def read_option(name: str, payloads: Mapping[str, str]) -> CommandReader:
    """Return a reader of options: the one that each payload commands."""

    def read(text: str) -> Values:
        return {name: payloads[text]} if text in payloads else {}

    return read


def reader_of(capability: Capability) -> CommandReader:
    """Return the reader of commands to *capability* in Home Assistant's plain form."""
    known = CAPABILITIES[capability.name]
    if known.kind == "bool":
        return read_flag(capability.name, _SWITCHED)
    if known.kind == "number":
        return read_number(capability.name, capability.bounds or known.bounds)
    options = capability.options or known.options
    if options:
        return read_option(capability.name, {option: option for option in options})
    return lambda text: {capability.name: text}


def take_settable(available: Available, name: str) -> Capability | None:
    """Take the capability *name* out of *available* where it is there and can be set."""
    known = available.get(name)
    return available.pop(name) if known is not None and known.settable else None


def take_reported(available: Available, name: str) -> Capability | None:
    """Take the capability *name* out of *available* where it is there and only reports."""
    known = available.get(name)
    return available.pop(name) if known is not None and known.readable and not known.settable else None


def take_choice(available: Available, name: str, unlike: str = "") -> Capability | None:
    """Take the capability *name* out of *available* where it can be set to options, none of which is *unlike*."""
    known = available.get(name)
    if known is None or not known.settable or not known.options or (unlike and unlike in known.options):
        return None
    return available.pop(name)


_SWITCHED = {"ON": True, "OFF": False}
_WIDE = (-1e15, 1e15)
_WHOLE = 1e15
