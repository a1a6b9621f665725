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

__all__ = ["offer_choice", "offer_flag", "offer_number", "offer_push"]

_WIDE = (-1e15, 1e15)


def offer_choice(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    options: tuple[str, ...],
    words: Mapping[str, str | None] | None = None,
    on_told: Callable[[str], None] = lambda _word: None,
) -> None:
    """Let *entity* have a word out of *options*; other words are not heard, and not told.

    Args:
        entity: Whose.
        name: Of the capability.
        source: Where it is said, if it is.
        command: Where it is told, if it is.
        options: The words.
        words: What further words mean; by default ``None`` means that it is unknown.
        on_told: Given each word that it is told.
    """
    if not options:
        return
    known: dict[str, str | None] = {**{word: word for word in options}, **(_UNKNOWN if words is None else words)}

    def read(text: str) -> Readings:
        return {name: known[text]} if text and text in known else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        word = require_option(name, value, options)
        told = (command.publication(word),) if command else ()
        on_told(word)
        return told

    entity.add_capability(name, readable=entity.hears(source, read), writer=write if command else None, options=options)
    entity.listens_at(command)


def offer_flag(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    payloads: Mapping[bool, str],
) -> None:
    """Let *entity* be on or off, which the *payloads* say; ``None`` means that it is unknown."""
    states: dict[str, bool | None] = {"None": None, payloads[False]: False, payloads[True]: True}

    def read(text: str) -> Readings:
        return {name: states[text]} if text and text in states else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        payload = payloads[require_bool(name, value)]
        return (command.publication(payload),) if command else ()

    entity.add_capability(name, readable=entity.hears(source, read), writer=write if command else None)
    entity.listens_at(command)


def offer_number(
    entity: Entity,
    name: str,
    source: ValueSource | None,
    command: CommandTopic | None,
    *,
    bounds: tuple[float, float] = _WIDE,
    unit: str = "",
    unknown: str = "None",
    heard: Callable[[float], float | None] = float,
    told: Callable[[float], float] = float,
) -> None:
    """Let *entity* have a number.

    Args:
        entity: Whose.
        name: Of the capability.
        source: Where it is said, if it is.
        command: Where it is told, if it is.
        bounds: Smallest and largest number that it is told.
        unit: Of the numbers, outside of the device.
        unknown: The word which says that it is unknown.
        heard: Makes the outside number of what the device says; None where that cannot be.
        told: Makes what the device is told of the outside number.
    """
    read = partial(read_number, name, unknown=unknown, heard=heard)

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        number = told(require_number(name, value, *bounds, unit))
        return (command.publication(number),) if command else ()

    entity.add_capability(
        name,
        readable=entity.hears(source, read),
        writer=write if command else None,
        unit=unit,
        bounds=bounds if command else (),
    )
    entity.listens_at(command)


def offer_push(entity: Entity, name: str, command: CommandTopic, payload: str) -> None:
    """Let *entity* be told true, and nothing else: it does something and has no state."""

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if value is not True:
            raise RefusedError(f"{name} {shown(value)}", "it takes true alone")
        return (command.publication(payload),)

    entity.add_capability(name, readable=False, writer=write)
    entity.listens_at(command)


_UNKNOWN: Mapping[str, str | None] = {"None": None}
