"""Builder of the part of one component, with the capabilities that several components share. Pure.

Source of the percentages: Home Assistant core 2025.4, ``util/scaling.py`` and ``util/percentage.py``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeVar, Unpack

from homebot.conventions.command_values import Writer, bool_writer, number_writer, option_writer, push_writer
from homebot.conventions.description import AutoExpiry, DescribedPart, Publications
from homebot.conventions.entity_rows import PLAIN_CLASSES
from homebot.conventions.part_builder import BytesPart, CapabilityFields
from homebot.conventions.payload import NO_READINGS, Readings, clean_text, meaning_reader, read_number, shown
from homebot.conventions.secrets import names_secret
from homebot.conventions.unreadable import unreadable
from homebot.devices.part import Category
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.topics import CommandTopic, ValueSource

ValueT = TypeVar("ValueT")

_UNKNOWN: Mapping[str, str | None] = {"None": None}
_WIDE = (-1e15, 1e15)
_MAX_RAW = 255
_FAR = 1e100
"""Beyond all values of devices, and still finite after multiplication."""


class Entity(BytesPart):
    """Builder of the part of one component.

    Args:
        service_type: A type of :data:`homebot.devices.device_types.DEVICE_TYPES`.
        tag: Its kind within the type; by default its ``device_class``, or its icon if that only tells a switch.
    """

    def __init__(self, config: DiscoveryConfig, service_type: str, tag: str | None = None) -> None:
        category = config.text("entity_category")
        if category not in _CATEGORIES:
            raise WireError(f"{config.component}: entity_category is {shown(category)}, not config or diagnostic")
        if tag is None:
            kind = config.device_class
            tag = (config.clean_text("icon") if kind in PLAIN_CLASSES and config.has("command_topic") else "") or kind
        super().__init__(
            config.part_id,
            service_type,
            name=config.clean_text("name"),
            advertised=config.component,
            tag=tag,
            category=_CATEGORIES[category],
        )
        self._config = config

    def read_text_from(self, source: ValueSource | None, read: Callable[[str], Readings]) -> bool:
        """Read the text at *source* with *read*, which never raises; return whether it is readable."""
        usable = self.usable(source)
        if usable is not None:
            self.read_from(usable.topic, partial(_read_text, usable, read))
        return usable is not None

    def usable(self, source: ValueSource | None) -> ValueSource | None:
        """Return *source*, or None if it is none, or that of a secret.

        With an unsupported template, the part shows the payload as ``raw`` instead.
        """
        if source is None or self._config.is_secret:
            return None
        if not source.problem:
            return source
        self.read_from(source.topic, partial(_read_text, source.without_template(), partial(_read_raw, source.problem)))
        self.add_capability("raw")
        return None

    def expire(self, capability: str) -> None:
        """Make *capability* unknown after the config's ``expire_after`` seconds; never if that is 0 or missing.

        Source: Home Assistant core 2025.4, ``components/mqtt/sensor.py`` and ``binary_sensor.py``.
        """
        seconds = self._config.seconds("expire_after")
        if seconds:
            self.add_expiry(AutoExpiry(capability, seconds))

    def add_commands(self, *commands: CommandTopic | None) -> None:
        """Add the topics of its commands."""
        for command in commands:
            if command is not None:
                self.add_command_topics(command.topic)

    def add_value(
        self,
        name: str,
        source: ValueSource | None,
        read: Callable[[str], Readings],
        command: CommandTopic | None = None,
        writer: Writer | None = None,
        **fields: Unpack[CapabilityFields],
    ) -> None:
        """Add the capability *name*: readable with a *source*, settable with a *writer*."""
        readable = self.read_text_from(source, read)
        self.add_capability(name, readable=readable, writer=writer, **fields)
        self.add_commands(command)

    def add_choice(
        self,
        name: str,
        source: ValueSource | None,
        command: CommandTopic | None,
        options: tuple[str, ...],
        meanings: Mapping[str, str | None] = _UNKNOWN,
        on_command: Callable[[str], None] = lambda _option: None,
    ) -> None:
        """Add a capability with one of *options*, and *meanings* of further texts; others are neither read nor sent.

        Args:
            on_command: Called with each commanded option.
        """
        if not options:
            return

        def write(option: str) -> Publications:
            publications = command.publish(option) if command else ()
            on_command(option)
            return publications

        read = meaning_reader(name, _not_empty({**{option: option for option in options}, **meanings}))
        writer = option_writer(name, options, write) if command else None
        self.add_value(name, source, read, command, writer, options=options)

    def add_flag(
        self,
        name: str,
        source: ValueSource | None,
        command: CommandTopic | None,
        payloads: Mapping[bool, str],
        states: Mapping[str, bool | None] | None = None,
    ) -> None:
        """Add a boolean with two *payloads*, reported by *states*, or else by the payloads."""
        if states is None:
            states = _not_empty({"None": None, payloads[False]: False, payloads[True]: True})
        writer = bool_writer(name, lambda on: command.publish(payloads[on])) if command else None
        self.add_value(name, source, meaning_reader(name, states), command, writer)

    def add_number(
        self,
        name: str,
        source: ValueSource | None,
        command: CommandTopic | None,
        *,
        bounds: tuple[float, float] = _WIDE,
        grid: tuple[float, ...] = (),
        unit: str = "",
        unknown: str = "None",
        from_device: Callable[[float], float | None] = float,
        to_device: Callable[[float], float] = float,
    ) -> None:
        """Add a number.

        Args:
            bounds: Smallest and largest commanded number.
            grid: See :attr:`homebot.devices.part.Capability.grid`.
            unit: The unit outside of the device.
            unknown: The text of an unknown number.
            from_device: Converts a reported number; None for an invalid one.
            to_device: Converts a commanded number.
        """
        read = partial(read_number, name, unknown=unknown, convert=from_device)
        writer = None
        if command is not None:
            writer = number_writer(name, bounds, unit, lambda number: command.publish(to_device(number)))
        bounds_of_writer = bounds if command else ()
        self.add_value(name, source, read, command, writer, unit=unit, bounds=bounds_of_writer, grid=grid)

    def add_push(self, name: str, command: CommandTopic, payload: str) -> None:
        """Add an action without state, commanded with true."""
        self.add_capability(name, readable=False, writer=push_writer(name, lambda: command.publish(payload)))
        self.add_commands(command)

    def build(self, payloads: object = None, *, digest: str = "") -> DescribedPart:
        """Return the finished part, with its echoes marked: states that may only repeat the command.

        These are all settable states if the config is ``optimistic``, or if every state topic is also a command topic.

        Source: Home Assistant core 2025.4, ``components/mqtt``: with ``optimistic`` a command is taken for the new
            state.
        """
        if self._config.flag("optimistic") or (self._readers and self._readers.keys() <= self._writes.keys()):
            for name, capability in self._capabilities.items():
                if capability.readable and capability.settable:
                    self._capabilities[name] = capability.model_copy(update={"echoed": True})
        return super().build(payloads or (self._config.of_commands() if self._writes else None), digest=digest)


_CATEGORIES: Mapping[str, Category] = {"": "", "config": "config", "diagnostic": "diagnostic"}


def _read_text(source: ValueSource, read: Callable[[str], Readings], payload: bytes) -> Readings:
    text = source.text(payload)
    return NO_READINGS if text is None else read(text)


def _read_raw(problem: str, text: str) -> Readings:
    unreadable(text, f"its template {problem}", is_template=True)
    return NO_READINGS if names_secret(text) else {"raw": clean_text(text, _MAX_RAW)}


def _not_empty(meanings: Mapping[str, ValueT]) -> Mapping[str, ValueT]:
    return {text: meaning for text, meaning in meanings.items() if text} if "" in meanings else meanings


@dataclass(frozen=True, slots=True)
class Scale:
    """Two values of a device that stand for 0 % and 100 %; the first may be the larger one.

    Raises:
        WireError: Both are the same.
    """

    zero: int
    full: int

    def __post_init__(self) -> None:
        if self.zero == self.full:
            raise WireError(f"0 % and 100 % are the same value, {self.zero}")

    def percent(self, value: float) -> float:
        """Return *value* in whole percent, rounded towards the zero; outside of 0 to 100 where the value is outside."""
        value = min(max(value, -_FAR), _FAR)
        return float((value - self.zero) * 100 // (self.full - self.zero))

    def value(self, percent: float) -> float:
        """Return the exact value that stands for *percent*."""
        return percent * (self.full - self.zero) / 100 + self.zero
