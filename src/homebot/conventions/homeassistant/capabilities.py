"""Capabilities that several components share: texts, numbers, switches and buttons, each with its own topics. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Publication
from homebot.conventions.homeassistant.command_topic import CommandTopic
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.value_parsing import read_number
from homebot.conventions.homeassistant.value_source import ValueSource
from homebot.conventions.payload import shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["add_choice", "add_flag", "add_number", "add_push"]

_WIDE = (-1e15, 1e15)


def add_choice(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    options: tuple[str, ...],
    meanings: Mapping[str, str | None] | None = None,
    on_command: Callable[[str], None] = lambda _option: None,
) -> None:
    """Let *entity* have one of *options*; others are neither read nor commanded.

    Args:
        entity: Whose.
        name: Of the capability.
        source: The source of its state; None where it has none.
        command: The topic of its commands; None where it takes none.
        options: Its options.
        meanings: Meanings of further texts; by default ``None`` means that it is unknown.
        on_command: Called with each option that is commanded.
    """
    if not options:
        return
    known: dict[str, str | None] = {
        **{option: option for option in options},
        **(_UNKNOWN if meanings is None else meanings),
    }

    def read(text: str) -> Readings:
        return {name: known[text]} if text and text in known else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        option = require_option(name, value, options)
        publications = (command.publication(option),) if command else ()
        on_command(option)
        return publications

    entity.add_capability(
        name, readable=entity.read_text_from(source, read), writer=write if command else None, options=options
    )
    entity.add_commands(command)


def add_flag(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    payloads: Mapping[bool, str],
) -> None:
    """Let *entity* be on or off, by its *payloads*; ``None`` means that it is unknown."""
    states: dict[str, bool | None] = {"None": None, payloads[False]: False, payloads[True]: True}

    def read(text: str) -> Readings:
        return {name: states[text]} if text and text in states else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        payload = payloads[require_bool(name, value)]
        return (command.publication(payload),) if command else ()

    entity.add_capability(name, readable=entity.read_text_from(source, read), writer=write if command else None)
    entity.add_commands(command)


def add_number(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    *,
    bounds: tuple[float, float] = _WIDE,
    unit: str = "",
    unknown: str = "None",
    from_device: Callable[[float], float | None] = float,
    to_device: Callable[[float], float] = float,
) -> None:
    """Let *entity* have a number.

    Args:
        entity: Whose.
        name: Of the capability.
        source: The source of its state; None where it has none.
        command: The topic of its commands; None where it takes none.
        bounds: Smallest and largest number that it takes.
        unit: Of the numbers, outside of the device.
        unknown: The text for unknown.
        from_device: Converts a number of the device; None where that cannot be.
        to_device: Converts a number for the device.
    """
    read = partial(read_number, name, unknown=unknown, convert=from_device)

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        number = to_device(require_number(name, value, *bounds, unit))
        return (command.publication(number),) if command else ()

    entity.add_capability(
        name,
        readable=entity.read_text_from(source, read),
        writer=write if command else None,
        unit=unit,
        bounds=bounds if command else (),
    )
    entity.add_commands(command)


def add_push(entity: Entity, name: str, command: CommandTopic, payload: str) -> None:
    """Let *entity* be told true, and nothing else: it does something and has no state."""

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if value is not True:
            raise RefusedError(f"{name} {shown(value)}", "it takes true alone")
        return (command.publication(payload),)

    entity.add_capability(name, readable=False, writer=write)
    entity.add_commands(command)


_UNKNOWN: Mapping[str, str | None] = {"None": None}
