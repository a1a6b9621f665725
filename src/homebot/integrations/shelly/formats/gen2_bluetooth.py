"""Bluetooth devices behind a Shelly of the second generation, each a device of its own. Pure.

The Shelly has a component for each device (``bthomedevice``, or ``blutrv`` of a radiator valve) and for each of its
values (``bthomesensor``), all with its address. Ids of parts are those of its broadcasts.

Source: Shelly Gen2+ API, BTHome Components and BluTrv.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Final, NamedTuple

from homebot.conventions.bluetooth.bthome_objects import BTHOME_OBJECTS, BUTTON, MODELS, TAGS, BluModel, model_called
from homebot.conventions.command_values import number_writer
from homebot.conventions.description import Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, text_of
from homebot.conventions.units import sensor_type
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Category
from homebot.integrations.shelly.formats.gen2_component import PRESSES, ShellyComponent
from homebot.integrations.shelly.formats.status import Fields, reader_of
from homebot.support.numbers import to_number

_VALVE_BOUNDS = (4.0, 30.0)


_KEY_PRESSES: Final = {
    **PRESSES,
    "long_double_push": "long_double",
    "long_triple_push": "long_triple",
    "hold_press": "hold",
}
_TURNS: Final = {"rotate_left": "rotate_left", "rotate_right": "rotate_right"}


class BluetoothDevice(NamedTuple):
    """The components of one Bluetooth device, its values first; *address* is in small letters with colons."""

    address: str
    components: tuple[ShellyComponent, ...]

    @property
    def name(self) -> str:
        """Its name in the Shelly, or else its model."""
        given = [component.name for component in self.components if component.kind != "bthomesensor" and component.name]
        return given[0] if given else self.model.name_at(self.address)

    @property
    def facts(self) -> dict[str, str]:
        """Its facts."""
        version = text_of(self.components[-1].status.get("fw_ver"))
        own = {"address": self.address.upper(), **({"sw_version": version} if version else {})}
        return {**self.model.facts, **own}

    @property
    def model(self) -> BluModel:
        """Its model."""
        config = self.components[-1].config
        number, ui = to_number(config.get("model_id")), as_fields(as_fields(config.get("meta")).get("ui"))
        return MODELS.get(int(number or 0)) or model_called(text_of(ui.get("local_name")))

    def parts(self) -> tuple[JsonPart, ...]:
        """Return its parts; a value that several components have counts once."""
        first, parts_by_id = self.components[0], dict[str, JsonPart]()
        if first.kind == "blutrv":  # it has all that its broadcasts have

            def set_target(celsius: float) -> Publications:
                params = {"id": 0, "target_C": round(celsius, 1)}
                return first.call("BluTRV.Call", method="TRV.SetTarget", params=params)

            valve = JsonPart("thermostat", "thermostat", commands=first.commands, tag="radiator_valve")
            first.read_status(valve, reader_of("target_C", "heating_setpoint"))
            writer = number_writer("heating_setpoint", _VALVE_BOUNDS, "°C", set_target)
            valve.add_capability("heating_setpoint", writer=writer, bounds=_VALVE_BOUNDS)
            first.add_value(valve, "local_temperature", "current_C")
            first.add_value(valve, "position", "pos")
            parts = chain((("thermostat", valve),), _own_parts(first))
        else:
            values = chain.from_iterable(_value_parts(component, self.model) for component in self.components)
            parts = chain(values, self._key_parts(), _own_parts(self.components[-1]))
        for part_id, part in parts:
            parts_by_id.setdefault(part_id, part)
        return tuple(parts_by_id.values())

    def _key_parts(self) -> Iterator[tuple[str, JsonPart]]:
        """Yield the buttons; before firmware 1.6 each had a component of its own."""
        device, count = self.components[-1], self.model.keys
        own = {
            _index(component): component for component in self.components if component.config.get("obj_id") == BUTTON
        }
        for number in sorted({*range(count), *own}):
            part_id = _number("button", number)
            part = JsonPart(part_id, "generic_switch", name=own[number].name if number in own else "")
            if number in own:
                own[number].add_presses(part, _KEY_PRESSES)
            device.add_presses(part, _KEY_PRESSES, number if max(count, len(own)) > 1 else None)
            yield part_id, part
        if self.model.has_wheel:
            wheel = JsonPart("dimmer", "generic_switch")
            device.add_presses(wheel, _TURNS)
            yield "dimmer", wheel


def group_by_address(components: Iterable[ShellyComponent]) -> tuple[BluetoothDevice, ...]:
    """Return the Bluetooth devices of those *components* that have an address."""
    components_by_address: defaultdict[str, list[ShellyComponent]] = defaultdict(list)
    for component in components:
        if address := text_of(component.config.get("addr")).casefold():
            components_by_address[address].append(component)
    return tuple(BluetoothDevice(address, tuple(own)) for address, own in components_by_address.items())


def _index(component: ShellyComponent) -> int:
    return int(to_number(component.config.get("idx")) or 0)


def _number(name: str, index: int) -> str:
    return f"{name}_{index + 1}" if index else name


def _value_parts(component: ShellyComponent, model: BluModel) -> Iterator[tuple[str, JsonPart]]:
    """Yield the part of a value; none if it is a button or has no known meaning."""
    object_id = component.config.get("obj_id")
    known = BTHOME_OBJECTS.get(object_id) if isinstance(object_id, int) else None
    kind = CAPABILITIES[known.capability].kind if known is not None and known.capability else "text"
    if known is None or kind == "text":
        return
    part_id = _number(known.name, _index(component))
    if (own := model.objects.get(part_id)) is not None:
        known, part_id = own, own.name
    capability, is_number, is_inverted = known.capability, kind == "number", known.is_inverted

    def decode(status: Fields) -> Readings:
        value = status.get("value")
        if isinstance(value, bool):
            return NO_READINGS if is_number else {capability: value is not is_inverted}
        number = to_number(value)
        return {capability: number} if number is not None and is_number else NO_READINGS

    category: Category = "diagnostic" if known.is_diagnostic else ""
    part = JsonPart(
        part_id, sensor_type(capability), name=component.name, tag=TAGS.get(known.name, ""), category=category
    )
    component.read_status(part, decode)
    part.add_capability(capability, unit=known.unit)
    yield part_id, part


def _own_parts(component: ShellyComponent) -> Iterator[tuple[str, JsonPart]]:
    for field, capability in (("battery", "battery"), ("rssi", "signal_strength")):
        if field in component.status:
            part = JsonPart(field, sensor_type(capability), category="diagnostic")
            component.add_value(part, capability, field)
            yield field, part
