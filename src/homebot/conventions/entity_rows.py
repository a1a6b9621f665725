"""Entities that describe themselves, as parts: rows of a capability with its reader and its writer. Pure.

Source of the modes of thermostats: Home Assistant core 2025.4, ``components/climate/__init__.py``.
"""

import re
from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Final, NamedTuple, TypeAlias

from homebot.conventions.capability_row import CapabilityRow
from homebot.conventions.command_values import require_bool, require_number, require_true
from homebot.conventions.device_classes import CLOSURE_CLASSES, condition_of, quantity_of
from homebot.conventions.payload import clean_text, read_progress
from homebot.conventions.units import Quantity, number_grid
from homebot.devices.part import CodeKind
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

Fields: TypeAlias = Mapping[str, object]
"""The fields of a message by name; an enum is its number, or None if that is unknown."""

ReadField: TypeAlias = Callable[[Fields, Fields], PlainValue]
"""Returns the value of a capability from the description and a complete state; None for unknown. Never raises."""

WriteField: TypeAlias = Callable[[Fields, PlainValue, str], Fields]
"""Returns the fields of a command from the description, a value and a code, which may be empty; raises RefusedError."""

_MAX_OPTIONS = 500
_MAX_TEXT = 255
_OF_DIGITS: Final = re.compile(r"(?:\\d|[0-9^$\[\]{}()+*?,|:-])+")
"""A regular expression that only digits match."""


EntityRow: TypeAlias = CapabilityRow[Fields, ReadField, WriteField]
"""A capability of a kind of entity, by its description."""


PLAIN_CLASSES: Final = frozenset({"", "outlet", "switch"})
"""Device classes that do not tell what is moved; an icon may."""


class EntityComponent(NamedTuple):
    """A component: the type of its parts, or a function of the description, and its rows.

    Attributes:
        tag: The tag of its parts; None for that of :func:`tag_of`.
    """

    service_type: str | Callable[[Fields], str]
    rows: tuple[EntityRow, ...]
    tag: str | None = None


def whole_of(fields: Fields, name: str) -> int:
    """Return a whole number or the number of an enum; 0 if the field is missing, as in Protocol Buffers."""
    value = fields.get(name)
    return value if isinstance(value, int) else 0


def text_of(fields: Fields, name: str) -> str:
    """Return a printable text; empty if there is none."""
    value = fields.get(name)
    return clean_text(value, _MAX_TEXT) if isinstance(value, str) else ""


def options_of(fields: Fields, name: str) -> tuple[str, ...]:
    """Return the texts of a list as the device spells them: the first 500, without empty and overlong ones."""
    value = fields.get(name)
    texts = value[:_MAX_OPTIONS] if isinstance(value, list) else []
    return tuple(dict.fromkeys(text for text in texts if isinstance(text, str) and 0 < len(text) <= _MAX_TEXT))


def has_feature(field: str, bits: int) -> Callable[[Fields], bool]:
    """Return a condition: all *bits* are set in a field of the description."""
    return lambda info: whole_of(info, field) & bits == bits


def read_flag(field: str) -> ReadField:
    """Return a reader of a boolean field."""
    return lambda _info, state: value if isinstance(value := state.get(field), bool) else None


def class_of(info: Fields) -> str:
    """Return the device class, in small letters; empty for none."""
    return text_of(info, "device_class").lower()


def tag_of(info: Fields, *, is_set: bool) -> str:
    """Return the device class; of a part that can be set, the icon if the class only tells a switch."""
    kind = class_of(info)
    return (text_of(info, "icon") if is_set and kind in PLAIN_CLASSES else "") or kind


def opening_type(info: Fields) -> str:
    """Return the type of a cover: doors and gates are closures."""
    return "closure" if class_of(info) in CLOSURE_CLASSES else "window_covering"


def switch_type(info: Fields) -> str:
    """Return the type of a switch."""
    return "plug" if class_of(info) == "outlet" else "switch"


def alarm_commands(info: Fields) -> tuple[str, ...]:
    """Return the states that an alarm panel can be commanded to; Home Assistant and ESPHome have the same features."""
    features = whole_of(info, "supported_features")
    return tuple(state for state, (bit, _) in ALARM_ACTIONS.items() if not bit or features & bit)


def code_of(told: object) -> CodeKind:
    """Return the characters of a code of the format *told*: ``number``, ``text``, or a regular expression."""
    if not isinstance(told, str) or not told:
        return ""
    return "digits" if told == "number" or _OF_DIGITS.fullmatch(told) else "text"


def push_row(name: str, command: Fields, when: Callable[[Fields], object] | None = None) -> EntityRow:
    """Return the row of an action without state."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        require_true(name, value)
        return command

    return EntityRow(name, None, write, when)


def quantity_of_entity(info: Fields) -> Quantity:
    """Return the quantity that a sensor measures, by its class and unit."""
    return quantity_of(class_of(info), text_of(info, "unit_of_measurement"))


def progress_rows(installing: str, percent: str) -> tuple[EntityRow, ...]:
    """Return the rows of the installation of an update, of which two fields tell; see :func:`read_progress`."""

    def read(name: str, _info: Fields, state: Fields) -> PlainValue:
        return read_progress(state, installing, percent).get(name)

    return tuple(EntityRow(name, partial(read, name)) for name in ("running", "update_progress"))


def quantity_row(read: ReadField, when: Callable[[Fields], object] | None = None) -> EntityRow:
    """Return the row of a sensor; *read* returns its number."""

    def read_amount(info: Fields, state: Fields) -> PlainValue:
        number = read(info, state)
        return quantity_of_entity(info).value(number) if isinstance(number, float) else None

    return EntityRow(
        "measurement",
        read_amount,
        when=when,
        named=lambda info: quantity_of_entity(info).capability,
        unit=lambda info: quantity_of_entity(info).unit,
    )


def condition_component(read: ReadField) -> EntityComponent:
    """Return the component of sensors that are on or off."""
    row = EntityRow("state", read, named=lambda info: condition_of(class_of(info))[1])
    return EntityComponent(lambda info: condition_of(class_of(info))[0], (row,))


def number_component(
    read: ReadField,
    bounds: Callable[[Fields], tuple[float, ...]],
    command: Callable[[float], Fields],
    least: str = "min_value",
) -> EntityComponent:
    """Return the component of numbers, with the *command* that sets one within its *bounds*, in steps from *least*."""

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        least, most = bounds(info) or _ANY_NUMBER
        return command(require_number("number", value, least, most))

    unit = partial(text_of, name="unit_of_measurement")
    grid = grid_of("step", least)
    return EntityComponent("x_setting", (EntityRow("number", read, write, bounds=bounds, unit=unit, grid=grid),))


def grid_of(step: str, least: str = "") -> Callable[[Fields], tuple[float, ...]]:
    """Return a function that returns the grid of a description with these fields, from 0 without *least*."""
    return lambda info: number_grid(info.get(least), info.get(step))


def text_component(read: ReadField, write: WriteField, is_secret: Callable[[Fields], object]) -> EntityComponent:
    """Return the component of texts; a secret one can be set but is never read."""
    secret = EntityRow("text", None, write, when=is_secret)
    return EntityComponent("x_setting", (secret, EntityRow("text", read, write, when=lambda info: not is_secret(info))))


_ANY_NUMBER = (-1e15, 1e15)

ALARM_ACTIONS: Mapping[str, tuple[int, str]] = {
    "disarmed": (0, "disarm"),
    "armed_home": (1, "arm_home"),
    "armed_away": (2, "arm_away"),
    "armed_night": (4, "arm_night"),
    "armed_vacation": (32, "arm_vacation"),
    "armed_custom_bypass": (16, "arm_custom_bypass"),
    "triggered": (8, "trigger"),
}
"""Actions of alarms by the state that each commands: the bit of ``supported_features`` that it needs, and its name."""

ALARM_STATES = (*ALARM_ACTIONS, "pending", "arming", "disarming")


_PAIR = 2
_SWITCHED_ON = ("heat_cool", "heat", "cool")
_HEATS = frozenset({"heat", "heat_cool", "auto"})
_COOLS = frozenset({"cool", "heat_cool"})


def climate_type(modes: Collection[str]) -> str:
    """Return the service type: an air conditioner cools, and dries or only blows."""
    return "room_air_conditioner" if "cool" in modes and ("dry" in modes or "fan_only" in modes) else "thermostat"


def modes_of_switch(modes: Collection[str]) -> dict[bool, str]:
    """Return the modes of on and off among *modes*. Of two modes, any other one than off is on."""
    is_pair = len(modes) == _PAIR and "off" in modes
    on = [mode for mode in (modes if is_pair else _SWITCHED_ON) if mode in modes and mode != "off"]
    return {**({True: on[0]} if on else {}), **({False: "off"} if "off" in modes else {})}


def switched_mode(modes: Collection[str], value: PlainValue) -> str:
    """Return the mode by which Home Assistant switches on or off, as *value* says.

    Raises:
        RefusedError: None of *modes* is that.
    """
    is_on = require_bool("on_off", value)
    wanted = (*_SWITCHED_ON, *(mode for mode in modes if mode != "off")) if is_on else ("off",)
    mode = next((mode for mode in wanted if mode in modes), None)
    if mode is None:
        raise RefusedError(f"on_off {value}", f"none of its modes is that: {', '.join(modes)[:200]}")
    return mode


def setpoints_of(modes: Collection[str]) -> tuple[str, ...]:
    """Return the capabilities of a single setpoint.

    It is a ``cooling_setpoint`` if the device cools, and a ``heating_setpoint`` if it heats or has no such modes.
    """
    cools = ("cooling_setpoint",) if _COOLS.intersection(modes) else ()
    return (*cools, "heating_setpoint") if not cools or _HEATS.intersection(modes) else cools
