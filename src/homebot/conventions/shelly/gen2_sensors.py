"""Sensors and electricity meters of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Temperature, Humidity, Illuminance, DevicePower, Smoke, Flood, Presence, Voltmeter,
Input, PM1, EM, EM1, EMData, EM1Data, and the measurements of Switch, Cover and Light.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, clean_text, percent_of
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent, flag, measured
from homebot.conventions.units import sensor_type
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["PRESSES", "SENSORS", "build_input", "build_meters", "build_own_temperature", "build_power", "build_sensor"]


_FLAGS = frozenset({"smoke", "water_leak", "occupancy", "power_detected"})

SENSORS: Mapping[str, tuple[str, str]] = {
    "smoke": ("alarm", "smoke"),
    "flood": ("alarm", "water_leak"),
    "presencezone": ("state", "occupancy"),
    "temperature": ("tC", "temperature"),
    "humidity": ("rh", "humidity"),
    "illuminance": ("lux", "illuminance"),
    "voltmeter": ("voltage", "voltage"),
    "cb": ("output", "power_detected"),  # a circuit breaker, which is no switch that an app may turn off
}
"""The components that are one sensor each: the field of its value, and the capability."""

PRESSES: Mapping[str, str] = {
    "single_push": "single",
    "double_push": "double",
    "triple_push": "triple",
    "long_push": "long",
}


def build_sensor(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a component that is one sensor."""
    field, capability = SENSORS[component.kind]
    if component.kind == "illuminance" and field not in component.status and "illumination" in component.status:
        field, capability = "illumination", "value"
    part = component.part("", sensor_type(capability), category="diagnostic" if component.is_inside else "")
    component.read_status(part, partial(_decode_sensor, field, capability))
    part.add_capability(capability)
    return (part,)


def _decode_sensor(field: str, capability: str, status: Fields) -> Readings:
    if status.get("errors"):
        return {capability: None}  # a number beside them is none: a display without sensor reports -275 °C
    if capability == "value":
        text = status.get(field)
        return {capability: clean_text(text)} if isinstance(text, str) else NO_READINGS
    if capability == "occupancy" and field not in status:
        field = "value"  # the name of the field in firmware from 1.8 on
    return (flag if capability in _FLAGS else measured)(field, capability)(status)


def build_power(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a battery, where the device has one, and whether it is plugged in."""
    part = component.part("", "x_battery", category="diagnostic")
    has = {
        "battery": "battery" in component.status or "external" not in component.status,
        "voltage": "V" in as_fields(component.status.get("battery")),
        "plugged_in": isinstance(component.status.get("external"), dict),
    }
    names = [name for name, is_there in has.items() if is_there]
    component.read_status(part, partial(_decode_power, frozenset(names)))
    for name in names:
        part.add_capability(name)
    return (part,)


def build_input(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe an input: a button, a switch, an analogue value or a counter, as it is set up."""
    kind = component.config.get("type")
    if component.config.get("enable") is False:
        return ()
    if kind == "analog" or (kind is None and "percent" in component.status and "state" not in component.status):
        part = component.part("", "x_sensor")
        component.read_status(part, measured("percent", "measurement"))
        part.add_capability("measurement", unit="%")
        return (part,)
    if kind == "count":
        part = component.part("", "x_sensor")
        component.read_status(part, _decode_counter)
        part.add_capability("measurement")
        return (part,)
    is_button = kind != "switch"
    part = component.part("", "generic_switch" if is_button else "x_binary_sensor")
    if kind == "switch" or component.status.get("state") is not None:
        component.read_status(part, flag("state", "state"))
        part.add_capability("state")
    if is_button:
        component.read_presses(part, PRESSES)
    return (part,)


def _decode_counter(status: Fields) -> Readings:
    total = to_number(as_fields(status.get("counts")).get("total"))
    return NO_READINGS if total is None else {"measurement": total}


def _decode_power(names: frozenset[str], status: Fields) -> Readings:
    found: dict[str, PlainValue] = {}
    battery, external = as_fields(status.get("battery")), as_fields(status.get("external"))
    if "percent" in battery:
        found["battery"] = percent_of(battery["percent"])
    if "V" in battery:
        found["voltage"] = to_number(battery["V"])
    if isinstance(present := external.get("present"), bool):
        found["plugged_in"] = present
    return {name: value for name, value in found.items() if name in names}


_ENERGY = 1 / 1000
"""Shelly counts watt-hours."""

_ELECTRICAL = (
    ("apower", "power"),
    ("act_power", "power"),
    ("voltage", "voltage"),
    ("current", "current"),
    ("freq", "frequency"),
)
_COUNTED = (("aenergy", "energy"), ("ret_aenergy", "energy_returned"))
_PHASES = ("a", "b", "c")
_TOTALS = (("total_act_power", "power"), ("total_current", "current"))


def build_meters(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe what a component measures of the electricity through it; nothing where it does not."""
    if component.kind == "em":
        return _build_phases(component)
    is_meter = component.kind in {"pm1", "em1"}
    if not is_meter and "apower" not in component.status:
        return ()
    part = component.part("" if is_meter else "meter", "electrical_meter")
    for field, capability in _ELECTRICAL:
        if field in component.status:
            component.add_measure(part, field, capability)
    for field, capability in _COUNTED:
        if isinstance(component.status.get(field), dict):
            component.read_status(part, partial(_decode_energy, field, capability))
            part.add_capability(capability)
    if component.kind == "em1":
        _count(component, part, f"em1data:{component.index}", "total_act_energy", "total_act_ret_energy")
    return (part,)


def build_own_temperature(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe how warm the device itself is, where the component reports that."""
    if not isinstance(component.status.get("temperature"), dict):
        return ()
    inner = measured("tC", "temperature")

    def decode(status: Fields) -> Readings:
        return inner(as_fields(status.get("temperature")))

    part = component.part("temperature", "temperature_sensor", category="diagnostic")
    component.read_status(part, decode)
    part.add_capability("temperature")
    return (part,)


def _build_phases(component: ShellyComponent) -> tuple[JsonPart, ...]:
    total = component.part("", "electrical_meter")
    for field, capability in _TOTALS:
        component.add_measure(total, field, capability)
    data = f"emdata:{component.index}"
    _count(component, total, data, "total_act", "total_act_ret")
    parts = [total]
    for phase in _PHASES:
        if f"{phase}_act_power" not in component.status:
            continue
        part = component.part(phase, "electrical_meter", tag=f"phase_{phase}")
        for field, capability in (("act_power", "power"), ("voltage", "voltage"), ("current", "current")):
            component.add_measure(part, f"{phase}_{field}", capability)
        _count(component, part, data, f"{phase}_total_act_energy", f"{phase}_total_act_ret_energy")
        parts.append(part)
    return tuple(parts)


def _count(component: ShellyComponent, part: JsonPart, key: str, drawn: str, returned: str) -> None:
    """Have *part* report the energy that the component *key* counts both ways."""
    for field, capability in ((drawn, "energy"), (returned, "energy_returned")):
        component.add_measure(part, field, capability, _ENERGY, key)


def _decode_energy(field: str, capability: str, status: Fields) -> Readings:
    total = to_number(as_fields(status.get(field)).get("total"))
    return NO_READINGS if total is None else {capability: total * _ENERGY}
