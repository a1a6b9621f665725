"""Rows: capabilities of a domain, with the attributes that they are read from and the services that set them. Pure.

Each reads the attributes of an entity with its state as ``state``, and writes the data of a service call with its
service as ``service``.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.entity_rows import EntityRow, Fields, ReadField, options_of, read_flag, whole_of
from homebot.conventions.payload import text_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import to_number

Condition: TypeAlias = Callable[[Fields], object]

_MAX_TEXT_CHARACTERS = 255


def has(*bits: int) -> Condition:
    """Return a condition: one of these *bits* is in ``supported_features``."""
    return lambda info: any(whole_of(info, "supported_features") & bit for bit in bits)


def read_number(field: str, factor: float = 1.0, least: float = -1e15, most: float = 1e15) -> ReadField:
    """Return a reader of a number, times *factor*; one out of the bounds is unknown."""

    def read(_info: Fields, state: Fields) -> PlainValue:
        number = to_number(state.get(field))
        return None if number is None or not least <= number * factor <= most else round(number * factor, 6)

    return read


def read_while_on(field: str, factor: float = 1.0) -> ReadField:
    """Return a reader of percents, which Home Assistant does not have of what is off."""
    read = read_number(field, factor, 0, 100)
    return lambda info, state: 0.0 if state.get("state") == "off" else read(info, state)


def read_text(field: str) -> ReadField:
    """Return a reader of a text."""
    return lambda _info, state: (
        text_of(value, _MAX_TEXT_CHARACTERS) if isinstance(value := state.get(field), str) else None
    )


def read_state(meanings: Mapping[str, PlainValue]) -> ReadField:
    """Return a reader of the state by its *meanings*; another one is unknown."""
    return lambda _info, state: meanings.get(value) if isinstance(value := state.get("state"), str) else None


def read_named(*states: str) -> ReadField:
    """Return a reader of the state, which is one of these; another one is unknown."""
    return read_state({state: state for state in states})


def bounds_of(info: Fields, low: str, high: str) -> tuple[float, float] | tuple[()]:
    """Return the bounds in two attributes; empty for none."""
    least, most = to_number(info.get(low)), to_number(info.get(high))
    return (least, most) if least is not None and most is not None and least < most else ()


def write_switch(_info: Fields, value: PlainValue, _code: str) -> Fields:
    """Return the service that switches."""
    return {"service": "turn_on" if require_bool("on_off", value) else "turn_off"}


SWITCH = EntityRow("on_off", read_state({"on": True, "off": False}), write_switch)
"""The row of a state that is on or off."""


def switch(on: int, off: int, read: ReadField | None = SWITCH.read) -> EntityRow:
    """Return the row of a switch that can be turned *on* and *off* by the bits for these, or has only one of them."""

    def write(info: Fields, value: PlainValue, code: str) -> Fields:
        service = write_switch(info, value, code)
        if not has(on if value else off)(info):
            raise RefusedError(f"on_off {value}", f"it can only be turned {'off' if value else 'on'} from here")
        return service

    return EntityRow("on_off", read, write, when=has(on, off))


def percent(
    name: str, field: str, service: str = "", argument: str = "", when: Condition | None = None, factor: float = 1.0
) -> EntityRow:
    """Return the row of percents, which are *factor* times the numbers of a field and of the argument of a service."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        number = require_number(name, value, 0, 100, "%")
        # cut off, as Home Assistant does: 67 would be the third of three speeds
        return {"service": service, argument or field: int(number) if factor == 1 else round(number / factor, 6)}

    return EntityRow(name, read_number(field, factor, 0, 100), write if service else None, when)


def reported(row: EntityRow, field: str) -> tuple[EntityRow, EntityRow]:
    """Return *row*, and a row that only reads: of an entity that has *field*, but cannot be set."""
    return row, replace(row, write=None, when=lambda info: field in info and not row.applies(info))


def choice(
    name: str, field: str, listed: str, service: str, argument: str = "", when: Condition | None = None
) -> EntityRow:
    """Return the row of a text, one of those that the attribute *listed* has."""

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        return {"service": service, argument or field: require_option(name, value, options_of(info, listed))}

    def applies(info: Fields) -> bool:
        return bool(options_of(info, listed) and (when is None or when(info)))

    return EntityRow(name, read_text(field), write, applies, lambda info: options_of(info, listed))


def moves(name: str, services: Mapping[str, tuple[int, str]], read: ReadField) -> tuple[EntityRow, EntityRow]:
    """Return the rows of an activity, with the feature and the service of each value that can be commanded."""

    def moves_of(info: Fields) -> tuple[str, ...]:
        features = whole_of(info, "supported_features")
        return tuple(move for move, (bit, _) in services.items() if features & bit)

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        return {"service": services[require_option(name, value, moves_of(info))][1]}

    return (
        EntityRow(name, read, when=lambda info: not moves_of(info)),
        EntityRow(name, read, write, when=moves_of, options=moves_of),
    )


def flag(name: str, field: str, service: str, when: Condition) -> EntityRow:
    """Return the row of a boolean attribute, which is also the argument of a *service*."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        return {"service": service, field: require_bool(name, value)}

    return EntityRow(name, read_flag(field), write, when)


def sensed(name: str, field: str, read: ReadField, unit: str = "") -> EntityRow:
    """Return the row of an attribute that not every entity of a domain has."""
    return EntityRow(name, read, None, lambda info: field in info, unit=unit)
