"""Entities of ESPHome devices as parts: rows of capability, reader and writer; states in, commands out. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``; names of fields and numbers of enums are taken from there.
"""

from collections.abc import Callable, Mapping

from homebot.conventions.capability_row import described, writer_of
from homebot.conventions.command_values import require_bool, require_number, require_option, require_transition
from homebot.conventions.entity_rows import (
    EntityComponent,
    EntityRow,
    Fields,
    ReadField,
    WriteField,
    options_of,
    read_flag,
    tag_of,
    text_of,
    whole_of,
)
from homebot.conventions.payload import Readings
from homebot.devices.capabilities import EVENTS
from homebot.devices.part import Category, Part
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

_MAX_TRANSITION_S = 4_000_000.0
"""Longest transition: ESPHome counts milliseconds with 32 bits."""

_TAGS: Mapping[str, str] = {"occupancy": "presence"}
"""Tags by class: ESPHome's radars, such as LD2410 and C4001, report ``occupancy``, its motion sensors ``motion``."""

_CATEGORIES: Mapping[int, Category] = {1: "config", 2: "diagnostic"}


class EsphomeEntity:
    """An entity of a device.

    Attributes:
        component: Its component: ``light``, ``binary_sensor``.
        info: Its description, as listed by the device.
        key: The device's numbers for its sub-device, 0 for the device itself, and for it.
        state: The fields of its last state; empty before the first.
    """

    def __init__(self, component: str, info: Fields, kind: EntityComponent) -> None:
        self.component = component
        self.info = info
        self.key = key_of(info)
        self.state: Fields = {}
        self._kind = kind
        rows = described(kind.rows, info, assumed=info.get("assumed_state") is True)
        self._capabilities = tuple(capability for capability, _ in rows)
        self._rows = {capability.name: row for capability, row in rows}
        self._fades = component == "light" and "level" in self._rows

    def part(self, part_id: str, owner: str = "") -> Part:
        """Return its part; the name of its sub-device, *owner*, precedes its own."""
        service_type, _, tag = self._kind
        declared = tag_of(self.info, is_set=any(capability.settable for capability in self._capabilities))
        return Part(
            id=part_id,
            name=f"{owner} {text_of(self.info, 'name')}".strip(),
            service_type=service_type if isinstance(service_type, str) else service_type(self.info),
            advertised=self.component,
            tag=_TAGS.get(declared, declared) if tag is None else tag,
            category=_CATEGORIES.get(whole_of(self.info, "entity_category"), ""),
            capabilities=self._capabilities,
            fades=self._fades,
        )

    def read(self, state: Fields) -> Readings:
        """Return the values in a state; all are unknown if the device has no state."""
        self.state = state
        readers = [(name, row.read) for name, row in self._rows.items() if row.read is not None]
        if state.get("missing_state") is True:
            return {name: None for name, _ in readers}
        readings = {name: read(self.info, state) for name, read in readers}
        return {name: value for name, value in readings.items() if value is not None or name not in EVENTS}

    def command(self, capability: str, value: PlainValue, transition: float = 0.0, code: str = "") -> Fields:
        """Return the fields of the command that sets *capability*.

        Raises:
            RefusedError: It is not settable, or needs a code, or the value is invalid; names the valid ones.
        """
        fields = writer_of(self._rows.values(), capability)(self.info, value, code)
        if transition and self._fades:
            return {**fields, "transition_length": require_transition(transition, _MAX_TRANSITION_S)}
        return fields


def key_of(fields: Fields) -> tuple[int, int]:
    """Return the numbers of the sub-device and of the entity in *fields*."""
    return whole_of(fields, "device_id"), whole_of(fields, "key")


def number_of(fields: Fields, name: str) -> float | None:
    """Return a number, rounded to the seven digits of a 32-bit float; None if it is not a number."""
    number = finite_number(fields.get(name))
    return None if number is None else float(f"{number:.7g}")


def numbers_of(fields: Fields, name: str) -> tuple[int, ...]:
    """Return the whole numbers of a list."""
    value = fields.get(name)
    return tuple(int(number) for number in value if isinstance(number, int)) if isinstance(value, list) else ()


def read_text(field: str) -> ReadField:
    """Return a reader of a text field."""
    return lambda _info, state: text_of(state, field) if isinstance(state.get(field), str) else None


def read_percent(field: str) -> ReadField:
    """Return a reader of a field from 0 to 1."""

    def read(_info: Fields, state: Fields) -> PlainValue:
        number = number_of(state, field)
        return None if number is None or not 0 <= number <= 1 else round(number * 100, 4)

    return read


def read_named(field: str, meanings: Mapping[int, PlainValue]) -> ReadField:
    """Return a reader of an enum with these *meanings*; another number is unknown."""
    return lambda _info, state: meanings.get(value) if isinstance(value := state.get(field), int) else None


def write_percent(name: str, field: str, **more: object) -> WriteField:
    """Return a writer of a field from 0 to 1, with *more* fields."""
    return lambda _info, value, _code: {**more, field: require_number(name, value, 0, 100, "%") / 100}


def listed(field: str) -> Callable[[Fields], Mapping[str, object]]:
    """Return the choices that are the texts of a list of the description."""
    return lambda info: {option: option for option in options_of(info, field)}


def supports(field: str) -> Callable[[Fields], bool]:
    """Return a condition: a boolean field of the description is set, if *field* is not empty."""
    return lambda info: not field or info.get(field) is True


def flag_row(name: str, field: str, needs: str = "") -> EntityRow:
    """Return the row of a boolean field of state and command."""
    return EntityRow(
        name, read_flag(field), lambda _info, value, _code: {field: require_bool(name, value)}, supports(needs)
    )


def percent_row(name: str, field: str, needs: str = "") -> EntityRow:
    """Return the row of a field from 0 to 1 in state and command."""
    return EntityRow(name, read_percent(field), write_percent(name, field), supports(needs))


def choice_row(name: str, field: str, choices: Callable[[Fields], Mapping[str, object]], **more: object) -> EntityRow:
    """Return the row of a field of state and command, with a value for each of the *choices* of the description.

    An entity without choices has no such row. A command has *more* fields.
    """

    def read(info: Fields, state: Fields) -> PlainValue:
        value = state.get(field)
        is_known = isinstance(value, (int, str))
        return next((option for option, known in choices(info).items() if is_known and known == value), None)

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        known = choices(info)
        return {**more, field: known[require_option(name, value, known)]}

    return EntityRow(name, read, write, choices, lambda info: tuple(choices(info)))
