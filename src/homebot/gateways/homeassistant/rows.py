"""Rows: capabilities of a domain, with the attributes that they are read from and the services that set them. Pure.

Each row reads the attributes of an entity with its state as ``state``, and writes the data of a service call with
its service as ``service``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.esphome.entity import EntityRow, Fields, ReadField, WriteField, options_of, whole_of
from homebot.conventions.payload import shown, text_of
from homebot.conventions.units import celsius_bounds, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import to_number

__all__ = [
    "SWITCH_ROW",
    "bounds_of",
    "celsius_row",
    "choice_row",
    "has",
    "move_rows",
    "number_row",
    "push_row",
    "read_celsius",
    "read_number",
    "read_state",
    "read_text",
    "target",
    "write_celsius",
]

Condition = Callable[[Fields], object]

_LONGEST = 255
_ANY_CELSIUS = (-100.0, 200.0)
_STATES = {"on": True, "off": False}


def has(*bits: int) -> Condition:
    """Return a condition: one of these *bits* is in ``supported_features``."""
    return lambda info: any(whole_of(info, "supported_features") & one for one in bits)


def read_number(field: str, factor: float = 1.0, least: float = -1e15, most: float = 1e15) -> ReadField:
    """Return a reader of a number, times *factor*; one out of the bounds is unknown."""

    def read(_info: Fields, state: Fields) -> PlainValue:
        number = to_number(state.get(field))
        return None if number is None or not least <= number * factor <= most else round(number * factor, 6)

    return read


def read_text(field: str) -> ReadField:
    """Return a reader of a text."""
    return lambda _info, state: text_of(value, _LONGEST) if isinstance(value := state.get(field), str) else None


def read_state(meanings: Mapping[str, PlainValue]) -> ReadField:
    """Return a reader of the state by its *meanings*; another one is unknown."""
    return lambda _info, state: meanings.get(value) if isinstance(value := state.get("state"), str) else None


def _write_switch(_info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "turn_on" if require_bool("on_off", value) else "turn_off"}


SWITCH_ROW = EntityRow("on_off", read_state(_STATES), _write_switch)
"""Of a state that is on or off."""


def number_row(
    name: str,
    field: str,
    service: str = "",
    argument: str = "",
    when: Condition | None = None,
    factor: float = 1.0,
) -> EntityRow:
    """Return the row of percents, which are *factor* times the numbers of a field and of the argument of a service."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        percent = require_number(name, value, 0, 100, "%")
        return {"service": service, argument or field: round(percent) if factor == 1 else round(percent / factor, 6)}

    return EntityRow(name, read_number(field, factor, 0, 100), write if service else None, "", when)


def choice_row(
    name: str, field: str, listed: str, service: str, argument: str = "", when: Condition | None = None
) -> EntityRow:
    """Return the row of a text, one of those that the attribute *listed* has."""

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        return {"service": service, argument or field: require_option(name, value, options_of(info, listed))}

    def applies(info: Fields) -> bool:
        return bool(options_of(info, listed)) and (when is None or bool(when(info)))

    return EntityRow(name, read_text(field), write, "", applies, lambda info: options_of(info, listed))


def move_rows(name: str, moves: Mapping[str, tuple[int, str]], read: ReadField) -> tuple[EntityRow, EntityRow]:
    """Return the rows of a movement; *moves* has the feature and the service of each that can be commanded."""

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        features = whole_of(info, "supported_features")
        known = {move: service for move, (bit, service) in moves.items() if not bit or features & bit}
        return {"service": known[require_option(name, value, known)]}

    can_move = has(*(bit for bit, _ in moves.values()))
    return EntityRow(name, read, when=lambda info: not can_move(info)), EntityRow(name, read, write, "", can_move)


def push_row(name: str, service: str, when: Condition | None = None) -> EntityRow:
    """Return the row of an action without state."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        if value is not True:
            raise RefusedError(f"{name} {shown(value)}", "it takes only true")
        return {"service": service}

    return EntityRow(name, None, write, "", when)


def _number(info: Fields, field: str) -> float | None:
    return to_number(info.get(field))


def bounds_of(info: Fields, low: str, high: str) -> tuple[float, float] | tuple[()]:
    """Return the bounds in two attributes; empty for none."""
    least, most = _number(info, low), _number(info, high)
    return (least, most) if least is not None and most is not None and least < most else ()


def read_celsius(field: str) -> ReadField:
    """Return a reader of a temperature."""

    def read(info: Fields, state: Fields) -> PlainValue:
        number = _number(state, field)
        return to_celsius(number, 3) if number is not None and info.get("is_fahrenheit") else number

    return read


def write_celsius(name: str, info: Fields, value: PlainValue) -> float:
    """Return a commanded setpoint in the unit of Home Assistant, within the entity's bounds."""
    bounds = bounds_of(info, "min_temp", "max_temp")
    celsius = require_number(name, value, *(_celsius_bounds(info) or _ANY_CELSIUS), "°C")
    number = to_fahrenheit(celsius, 3) if info.get("is_fahrenheit") else celsius
    return min(max(number, bounds[0]), bounds[1]) if bounds else number


def _celsius_bounds(info: Fields) -> tuple[float, float] | tuple[()]:
    bounds = bounds_of(info, "min_temp", "max_temp")
    return celsius_bounds(*bounds) if bounds and info.get("is_fahrenheit") else bounds


def target(name: str, read: ReadField, write: WriteField, when: Condition) -> EntityRow:
    """Return the row of a setpoint."""
    return EntityRow(name, read, write, "", when, (), _celsius_bounds, "°C")


def celsius_row(name: str, field: str) -> EntityRow:
    """Return the row of a measured temperature, of an entity that has had it."""
    return EntityRow(name, read_celsius(field), None, "", lambda info: field in info, unit="°C")
