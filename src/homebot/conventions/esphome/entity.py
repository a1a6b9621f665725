"""An entity of an ESPHome device as a part of the vocabulary: decodes its states and encodes its commands. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``; names of fields and numbers of enums are taken from there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

from homebot.conventions.command_values import require_bool, require_number, require_option, require_transition
from homebot.conventions.payload import Readings, clean_text, shown
from homebot.devices.capabilities import EVENTS
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import finite_number

__all__ = [
    "EsphomeEntity",
    "FieldReader",
    "FieldWriter",
    "Fields",
    "flag_reader",
    "key_of",
    "number_of",
    "numbers_of",
    "options_of",
    "percent_reader",
    "percent_writer",
    "table_reader",
    "text_of",
    "whole_of",
]

Fields: TypeAlias = Mapping[str, object]
"""The fields of a message by name; an enum is its number, or None if that is not known."""

FieldReader: TypeAlias = Callable[[Fields], PlainValue]
"""Returns the value of one capability from a complete state; None for unknown. Never raises."""

FieldWriter: TypeAlias = Callable[[PlainValue, str], Fields]
"""Returns the fields of the command that sets a value, given a code for those that need one; raises RefusedError."""

_MAX_OPTIONS = 500
_MAX_TEXT = 255
_CATEGORIES: Mapping[int, Category] = {1: "config", 2: "diagnostic"}


class EsphomeEntity:
    """An entity: capabilities are added first, then it decodes states and encodes commands.

    Args:
        kind: Its component: ``light``, ``binary_sensor``.
        info: Its description, as listed by the device.
        service_type: The type of the part; see :data:`homebot.devices.device_types.DEVICE_TYPES`.
        tag: The kind within its type; by default its device class.

    Attributes:
        kind: The same.
        info: The same.
        key: The device's number for it, and that of the sub-device that it belongs to, which is 0 for the device.
        state: The fields of its last state; empty before the first.
    """

    def __init__(self, kind: str, info: Fields, service_type: str, tag: str | None = None) -> None:
        self.kind = kind
        self.key = key_of(info)
        self.state: Fields = {}
        self.info = info
        self._service_type = service_type
        self._tag = text_of(info, "device_class") if tag is None else tag
        self._capabilities: list[Capability] = []
        self._readers: dict[str, FieldReader] = {}
        self._writers: dict[str, FieldWriter] = {}

    def add(
        self,
        name: str,
        read: FieldReader | None,
        write: FieldWriter | None = None,
        *,
        unit: str = "",
        bounds: tuple[float, ...] = (),
        options: tuple[str, ...] = (),
    ) -> None:
        """Add the capability *name*: readable if *read* is given, settable if *write* is."""
        if read is not None:
            self._readers[name] = read
        if write is not None:
            self._writers[name] = write
        is_assumed = self.info.get("assumed_state") is True  # it reports its last command
        self._capabilities.append(
            Capability(
                name=name,
                readable=read is not None,
                settable=write is not None,
                unit=unit,
                bounds=bounds,
                options=options,
                echoed=is_assumed and read is not None and write is not None,
            )
        )

    def add_flag(self, name: str, field: str) -> None:
        """Add a capability that is a boolean field of state and command."""
        self.add(name, flag_reader(field), lambda value, _code: {field: require_bool(name, value)})

    def add_percent(self, name: str, field: str) -> None:
        """Add a percentage that is a field from 0 to 1 in state and command."""
        self.add(name, percent_reader(field), percent_writer(name, field))

    def add_choice(self, name: str, field: str, choices: Mapping[str, object]) -> None:
        """Add a choice that is a field of state and command; *choices* are the values of the field by option."""
        read = table_reader(field, {number: option for option, number in choices.items()})
        options = tuple(choices)
        self.add(
            name, read, lambda value, _code: {field: choices[require_option(name, value, options)]}, options=options
        )

    def part(self, part_id: str, owner: str = "") -> Part:
        """Return its part; the name of its sub-device, *owner*, precedes its own."""
        return Part(
            id=part_id,
            name=f"{owner} {text_of(self.info, 'name')}".strip(),
            service_type=self._service_type,
            advertised=self.kind,
            tag=self._tag,
            category=_CATEGORIES.get(whole_of(self.info, "entity_category"), ""),
            capabilities=tuple(self._capabilities),
        )

    def read(self, state: Fields) -> Readings:
        """Return the values in a state; all are unknown if the device has no state."""
        self.state = state
        if state.get("missing_state") is True:
            return dict.fromkeys(self._readers, None)
        found = {name: read(state) for name, read in self._readers.items()}
        return {name: value for name, value in found.items() if value is not None or name not in EVENTS}

    def command(self, capability: str, value: PlainValue, transition: float = 0.0, code: str = "") -> Fields:
        """Return the fields of the command that makes *capability* become *value*.

        Raises:
            RefusedError: It cannot do that, or is not allowed to without a code; says which values it takes.
        """
        write = self._writers.get(capability)
        if write is None:
            raise RefusedError(shown(capability), f"this part takes {', '.join(self._writers) or 'nothing'}")
        fields = write(value, code)
        if self.kind == "light" and transition:
            return {**fields, "transition_length": require_transition(transition, _MOST_SECONDS)}
        return fields


_MOST_SECONDS = 4_000_000.0
"""Longest transition: ESPHome counts milliseconds with 32 bits."""


def key_of(fields: Fields) -> tuple[int, int]:
    """Return the numbers of the sub-device and of the entity in *fields*."""
    return whole_of(fields, "device_id"), whole_of(fields, "key")


def whole_of(fields: Fields, name: str) -> int:
    """Return a whole number or the number of an enum; 0 if the field is missing, as in Protocol Buffers."""
    value = fields.get(name)
    return value if isinstance(value, int) else 0


def number_of(fields: Fields, name: str) -> float | None:
    """Return a number, rounded to the seven digits of a 32-bit float; None if it is not a number."""
    number = finite_number(fields.get(name))
    return None if number is None else float(f"{number:.7g}")


def text_of(fields: Fields, name: str) -> str:
    """Return a printable text; empty if there is none."""
    value = fields.get(name)
    return clean_text(value, _MAX_TEXT) if isinstance(value, str) else ""


def options_of(fields: Fields, name: str) -> tuple[str, ...]:
    """Return the texts of a list as the device spells them: the first 500, without empty and overlong ones."""
    value = fields.get(name)
    texts = value[:_MAX_OPTIONS] if isinstance(value, list) else []
    return tuple(dict.fromkeys(one for one in texts if isinstance(one, str) and 0 < len(one) <= _MAX_TEXT))


def numbers_of(fields: Fields, name: str) -> tuple[int, ...]:
    """Return the whole numbers of a list."""
    value = fields.get(name)
    return tuple(int(one) for one in value if isinstance(one, int)) if isinstance(value, list) else ()


def flag_reader(field: str) -> FieldReader:
    """Return a reader of a field that is true or false."""

    def read(state: Fields) -> PlainValue:
        value = state.get(field)
        return value if isinstance(value, bool) else None

    return read


def percent_reader(field: str) -> FieldReader:
    """Return a reader of a field from 0 to 1."""

    def read(state: Fields) -> PlainValue:
        number = number_of(state, field)
        return None if number is None or not 0 <= number <= 1 else round(number * 100, 4)

    return read


def percent_writer(name: str, field: str) -> FieldWriter:
    """Return a writer of a field from 0 to 1."""
    return lambda value, _code: {field: require_number(name, value, 0, 100, "%") / 100}


def table_reader(field: str, meanings: Mapping[object, str]) -> FieldReader:
    """Return a reader of a field with values of these *meanings*; another value is unknown."""

    def read(state: Fields) -> PlainValue:
        value = state.get(field)
        return meanings.get(value) if isinstance(value, (int, str)) else None

    return read
