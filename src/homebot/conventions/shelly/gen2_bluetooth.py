"""Bluetooth devices that a Shelly publishes as a gateway: they use BTHome, and each value is a component. Pure.

Source: Shelly Gen2+ API, components BTHomeDevice and BTHomeSensor.
"""

from __future__ import annotations

from homebot.conventions.bthome.objects import BTHOME_OBJECTS, BUTTON
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent
from homebot.conventions.shelly.gen2_sensors import PRESSES
from homebot.conventions.units import sensor_type
from homebot.devices.capabilities import CAPABILITIES
from homebot.numbers import to_number

__all__ = ["build_bluetooth_device", "build_bluetooth_sensor"]


def build_bluetooth_device(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a device itself: its battery, how well it is received, and the presses of its buttons."""
    parts: list[JsonPart] = []
    for field, capability in (("battery", "battery"), ("rssi", "signal_strength")):
        if field in component.status:
            part = component.part(field, sensor_type(capability), category="diagnostic")
            component.add_measure(part, field, capability)
            parts.append(part)
    keys = component.part("", "generic_switch")
    component.read_presses(keys, PRESSES)
    return (keys, *parts)


def build_bluetooth_sensor(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe one value of a device; nothing where it is not known what it means."""
    object_id = component.config.get("obj_id")
    if object_id == BUTTON:
        part = component.part("", "generic_switch")
        component.read_presses(part, PRESSES)
        return (part,)
    known = BTHOME_OBJECTS.get(object_id) if isinstance(object_id, int) else None
    kind = CAPABILITIES[known.capability].kind if known is not None and known.capability else "text"
    if known is None or kind == "text":
        return ()
    capability, is_number, is_inverted = known.capability, kind == "number", known.is_inverted

    def decode(status: Fields) -> Readings:
        value = status.get("value")
        if isinstance(value, bool):
            return NO_READINGS if is_number else {capability: value is not is_inverted}
        number = to_number(value)
        return {capability: number} if number is not None and is_number else NO_READINGS

    part = component.part("", sensor_type(capability), category="diagnostic" if known.is_diagnostic else "")
    component.read_status(part, decode)
    part.add_capability(capability, unit=known.unit)
    return (part,)
