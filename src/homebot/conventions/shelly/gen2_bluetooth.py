"""Bluetooth devices that a Shelly publishes as a gateway: they use BTHome, and each value is a component. Pure.

Source: Shelly Gen2+ API, components BTHomeDevice and BTHomeSensor; BTHome v2, object ids.
"""

from __future__ import annotations

from collections.abc import Mapping

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
    if object_id == _BUTTON:
        part = component.part("", "generic_switch")
        component.read_presses(part, PRESSES)
        return (part,)
    known = _OBJECTS.get(object_id) if isinstance(object_id, int) else None
    if known is None:
        return ()
    capability, unit = known
    is_number = CAPABILITIES[capability].kind == "number"

    def decode(status: Fields) -> Readings:
        value = status.get("value")
        if isinstance(value, bool):
            return NO_READINGS if is_number else {capability: value}
        number = to_number(value)
        return {capability: number} if number is not None and is_number else NO_READINGS

    part = component.part("", sensor_type(capability), category="diagnostic" if capability in _DIAGNOSTIC else "")
    component.read_status(part, decode)
    part.add_capability(capability, unit=unit)
    return (part,)


_BUTTON = 58
_DIAGNOSTIC = frozenset({"battery", "battery_low", "battery_charging"})
_CAPABILITIES: Mapping[str, tuple[int, ...]] = {
    "state": (15,),
    "power_detected": (16,),
    "contact": (17, 26, 27, 45),
    "battery_low": (21,),
    "battery_charging": (22,),
    "carbon_monoxide_alarm": (23,),
    "freeze": (24,),
    "connectivity": (25,),
    "gas": (28,),
    "heat": (29,),
    "light_detected": (30,),
    "unlocked": (31,),
    "water_leak": (32,),
    "occupancy": (33, 35, 37),
    "moving": (34,),
    "plugged_in": (36,),
    "problem": (38,),
    "running": (39,),
    "safety": (40,),
    "smoke": (41,),
    "sound": (42,),
    "tamper": (43,),
    "vibration": (44,),
    "battery": (1,),
    "temperature": (2, 69, 87, 88),
    "humidity": (3, 46),
    "pressure": (4,),
    "illuminance": (5,),
    "energy": (10, 77),
    "power": (11, 92),
    "voltage": (12, 74),
    "pm25": (13,),
    "pm10": (14,),
    "carbon_dioxide": (18,),
    "volatile_organic_compounds": (19,),
    "soil_moisture": (20, 47),
    "current": (67, 93),
    "flow": (73,),
}
_MEASURED: Mapping[str, tuple[int, ...]] = {
    "": (9, 61, 62, 70, 89, 90, 91),
    "kg": (6,),
    "lb": (7,),
    "°C": (8,),
    "°": (63, 94),
    "mm": (64, 95),
    "m": (65,),
    "s": (66,),
    "m/s": (68, 98),
    "L": (71, 78, 79, 85),
    "mL": (72,),
    "m³": (75, 76),
    "m/s²": (81, 99),
    "°/s": (82,),
    "µS/cm": (86,),
    "rpm": (97,),
}
"""Numbers of no capability of their own, by their unit."""

_OBJECTS: Mapping[int, tuple[str, str]] = {
    **{one: (capability, "") for capability, ids in _CAPABILITIES.items() for one in ids},
    **{one: ("measurement", unit) for unit, ids in _MEASURED.items() for one in ids},
}
"""Capability and unit of each object id."""
