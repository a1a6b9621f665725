"""One entity in a Home Assistant for an exposed part: its config, its states and its commands. Pure.

Entities with one value each are here too: switches, numbers, selects, buttons, sensors, events.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt``: binary_sensor.py, button.py, event.py, number.py,
scene.py, select.py, sensor.py, switch.py, tag.py, text.py.
"""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from homebot.conventions.device_classes import CONDITION_CLASSES, QUANTITY_CLASSES
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.support.numbers import to_number

Values: TypeAlias = Mapping[str, PlainValue]
"""The known values of a part, by capability."""

StateWriter: TypeAlias = Callable[[Values], str]
"""Writes the payload of the values; an empty one clears the retained state."""

CommandReader: TypeAlias = Callable[[str], Values]
"""Reads the commanded values of a payload, by capability and in this order; empty for no command. Never raises."""

Available: TypeAlias = dict[str, Capability]
"""The capabilities of a part that are in no entity yet, by name."""

_SWITCHED = ("ON", "OFF")
_NO_FIELDS: Mapping[str, object] = MappingProxyType({})
_WIDE = (-1e15, 1e15)
_WHOLE = 1e15


class Row(NamedTuple):
    """One capability of an entity, and the fields of the config that belong to it.

    Attributes:
        capability: Its name. It is left out if it lacks one of the topics.
        state_key: The field of its state topic.
        command_key: The field of its command topic; empty for a capability that is only reported.
        options_key: The field of its options; empty if it needs none.
        reserved: An option with another meaning in Home Assistant, with which the capability is left out.
        unknown: The payload of an unknown value.
        payloads: The payloads of true and false.
        commands: The option of each payload, if payloads and options differ.
        is_reported: Whether a capability that is never reported is left out.
    """

    capability: str
    state_key: str
    command_key: str = ""
    options_key: str = ""
    reserved: str = ""
    unknown: str = "None"
    payloads: tuple[str, str] = _SWITCHED
    commands: Mapping[str, str] = MappingProxyType({})
    is_reported: bool = False

    def fits(self, capability: Capability) -> bool:
        """Return whether *capability* can be published by this row."""
        if not self.command_key:
            return capability.readable and not capability.settable
        if self.options_key and (not capability.options or self.reserved in capability.options):
            return False
        return capability.settable and (capability.readable or not self.is_reported)


@dataclass(frozen=True, slots=True)
class PublishedState:
    """The state of some capabilities on one topic; an event is not retained."""

    topic: str
    capabilities: frozenset[str]
    write: StateWriter
    is_event: bool = False


class PublishedEntity:
    """An entity in the making.

    Args:
        base: The level above the topics of its part.
        name: Distinguishes it from the part's other entities; empty for the main one.
        fields: The fields that name no topic.

    Attributes:
        config: All fields of its config so far.
        commands: Readers of its commands, by topic.
    """

    def __init__(self, base: str, component: str, name: str = "", fields: Mapping[str, object] = _NO_FIELDS) -> None:
        self.component = component
        self.name = name
        self.config: dict[str, object] = dict(fields)
        self.states: list[PublishedState] = []
        self.commands: dict[str, CommandReader] = {}
        self._base = base

    def add_state(
        self,
        key: str,
        name: str,
        write: StateWriter | None = None,
        capabilities: Iterable[str] = (),
        *,
        is_event: bool = False,
    ) -> None:
        """Publish *capabilities*, by default *name* alone, on the topic in the field *key*."""
        topic = self.config[key] = f"{self._base}/{name}/state"
        names = frozenset(capabilities) or frozenset({name})
        self.states.append(PublishedState(topic, names, write or state_writer(name), is_event))

    def add_command(self, key: str, name: str, read: CommandReader) -> None:
        """Read commands from the topic in the field *key*."""
        topic = self.config[key] = f"{self._base}/{name}/set"
        self.commands[topic] = read

    def add(self, capability: Capability, row: Row) -> None:
        """Publish *capability* as *row* says."""
        if row.options_key:
            self.config[row.options_key] = list(capability.options)
        if capability.readable and row.state_key:
            self.add_state(row.state_key, capability.name, state_writer(capability.name, row.unknown, row.payloads))
        if capability.settable and row.command_key:
            self.add_command(row.command_key, capability.name, _command_reader(capability, row))

    def add_rows(self, available: Available, rows: Iterable[Row]) -> None:
        """Move the capabilities that fit *rows* from *available* to this entity."""
        for row in rows:
            capability = available.get(row.capability)
            if capability is not None and row.fits(capability):
                self.add(available.pop(row.capability), row)


def is_settable(available: Available, name: str) -> bool:
    """Return whether the capability *name* is available and settable."""
    return name in available and available[name].settable


def settable_payloads(capability: Capability, payloads: Mapping[str, str]) -> dict[str, str]:
    """Return the *payloads* of the options of *capability*, or all if it names no options."""
    return {key: option for key, option in payloads.items() if not capability.options or option in capability.options}


def state_writer(name: str, unknown: str = "None", payloads: tuple[str, str] = _SWITCHED) -> StateWriter:
    """Return the writer of one capability in Home Assistant's plain form."""

    def write(values: Values) -> str:
        value = values.get(name)
        if isinstance(value, bool):
            return payloads[0] if value else payloads[1]
        if isinstance(value, float):
            return str(int(value)) if value.is_integer() and abs(value) < _WHOLE else repr(value)
        return value if isinstance(value, str) else unknown

    return write


def payload_reader(name: str, payloads: Mapping[str, PlainValue]) -> CommandReader:
    """Return a reader of the values that *payloads* command."""
    return lambda text: {name: payloads[text]} if text in payloads else {}


def _command_reader(capability: Capability, row: Row) -> CommandReader:
    """Return the reader of commands to *capability* in Home Assistant's plain form."""
    name, known = capability.name, CAPABILITIES[capability.name]
    if row.commands:
        return payload_reader(name, settable_payloads(capability, row.commands))
    if known.kind == "bool":
        return payload_reader(name, dict(zip(row.payloads, (True, False), strict=True)))
    if known.kind == "number":
        least, most = capability.bounds or known.bounds or _WIDE

        def read(text: str) -> Values:
            number = to_number(text)
            return {name: number} if number is not None and least <= number <= most else {}

        return read
    options = capability.options or known.options
    return payload_reader(name, {option: option for option in options}) if options else lambda text: {name: text}


_BUTTONS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "push": ("button", {"payload_press": "PRESS"}),
    "locate": ("button", {"payload_press": "PRESS", "device_class": "identify"}),
    "scene": ("scene", {"payload_on": "PRESS"}),
}
"""Component and fields of the capabilities that are pressed."""

_MAX_STEPS = 200.0
_STEPS = ((1.0, 0.01), (50.0, 0.1))
"""The step of a number entity, by the width of its range."""

_USUAL_CLASSES: Mapping[str, str] = {"contact": "opening", "occupancy": "occupancy", "tamper": "tamper"}
"""The most general of several classes."""


def publish_single(part: Part, capability: Capability, base: str) -> tuple[PublishedEntity, ...]:
    """Return the entity of *capability* alone; none if Home Assistant has no component for it."""
    known = CAPABILITIES.get(capability.name)
    if known is None or known.kind == "numbers":
        return ()
    if capability.name in _BUTTONS:
        if not capability.settable:
            return ()
        component, fields = _BUTTONS[capability.name]
        entity = PublishedEntity(base, component, capability.name, fields)
        entity.add_command("command_topic", capability.name, payload_reader(capability.name, {"PRESS": True}))
        return (entity,)
    if capability.settable:
        return (_setting(part, capability, base),)
    return (_sensor(part, capability, base),) if capability.readable else ()


def _setting(part: Part, capability: Capability, base: str) -> PublishedEntity:
    known = CAPABILITIES[capability.name]
    options = capability.options or known.options
    fields: dict[str, object] = {}
    if known.kind == "bool":
        component = "switch"
        if part.service_type == "plug" and capability.name == "on_off":
            fields = {"device_class": "outlet"}
    elif known.kind == "number":
        component = "number"
        low, high = capability.bounds or known.bounds or _WIDE
        if low >= high:
            low, high = _WIDE
        span = high - low
        fields = {"min": low, "max": high, "mode": "box" if span > _MAX_STEPS else "auto"}
        fields["step"] = next((step for most, step in _STEPS if span <= most), 1.0)
        if capability.grid:
            fields["step"] = capability.grid[1]
        if unit := capability.unit or known.unit:
            fields["unit_of_measurement"] = unit
    else:
        component, fields = ("select", {"options": list(options)}) if options else ("text", {})
    entity = PublishedEntity(base, component, capability.name, fields)
    entity.add(capability, Row(capability.name, "state_topic", "command_topic"))
    return entity


def _sensor(part: Part, capability: Capability, base: str) -> PublishedEntity:
    """Build a sensor or an event; the message of an event is not retained."""
    name, known = capability.name, CAPABILITIES[capability.name]
    if name == "press" and capability.options:
        entity = PublishedEntity(base, "event", name, {"event_types": list(capability.options)})
        entity.add_state("state_topic", name, _event_text, is_event=True)
        return entity
    if name == "scan":
        entity = PublishedEntity(base, "tag", name)
        entity.add_state("topic", name, is_event=True)
        return entity
    if known.kind == "bool":
        classes = CONDITION_CLASSES.get(name, ())
        device_class = part.tag if part.tag in classes else _USUAL_CLASSES.get(name, "".join(classes[:1]))
        entity = PublishedEntity(base, "binary_sensor", name, _fill(device_class=device_class))
    elif known.kind == "number":
        fields = _fill(
            device_class=QUANTITY_CLASSES.get(name, ""),
            unit_of_measurement=capability.unit or known.unit,
            state_class="total_increasing" if name == "energy" else "measurement",
        )
        entity = PublishedEntity(base, "sensor", name, fields)
    else:
        entity = PublishedEntity(base, "sensor", name)
    entity.add_state("state_topic", name, is_event=name == "press")
    return entity


def _event_text(values: Values) -> str:
    return json.dumps({"event_type": values.get("press")}, ensure_ascii=False)


def _fill(**fields: str) -> dict[str, object]:
    return {key: value for key, value in fields.items() if value}
