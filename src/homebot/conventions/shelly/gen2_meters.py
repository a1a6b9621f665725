"""Electricity meters of Shelly's second generation, and its own temperature. Pure.

Source: Shelly Gen2+ API, components PM1, EM, EM1, EMData, EM1Data, and the measurements of Switch, Cover and Light.
"""

from __future__ import annotations

from functools import partial

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent, measured
from homebot.numbers import to_number

__all__ = ["build_meters", "build_own_temperature"]

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
            component.read_status(part, measured(field, capability))
            part.add_capability(capability)
    for field, capability in _COUNTED:
        if isinstance(component.status.get(field), dict):
            component.read_status(part, partial(_decode_energy, field, capability))
            part.add_capability(capability)
    if component.kind == "em1":
        _count(component, part, f"em1data:{component.index}", "total_act_energy", "total_act_ret_energy")
    return (part,)


def build_own_temperature(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe how warm the device itself is, where the component tells."""
    if not isinstance(component.status.get("temperature"), dict):
        return ()
    inner = measured("tC", "temperature")

    def decode(status: Fields) -> Readings:
        temperature = status.get("temperature")
        return inner(temperature) if isinstance(temperature, dict) else NO_READINGS

    part = component.part("temperature", "temperature_sensor", category="diagnostic")
    component.read_status(part, decode)
    part.add_capability("temperature")
    return (part,)


def _build_phases(component: ShellyComponent) -> tuple[JsonPart, ...]:
    total = component.part("", "electrical_meter")
    for field, capability in _TOTALS:
        component.read_status(total, measured(field, capability))
        total.add_capability(capability)
    data = f"emdata:{component.index}"
    _count(component, total, data, "total_act", "total_act_ret")
    parts = [total]
    for phase in _PHASES:
        if f"{phase}_act_power" not in component.status:
            continue
        part = component.part(phase, "electrical_meter", tag=f"phase_{phase}")
        for field, capability in (("act_power", "power"), ("voltage", "voltage"), ("current", "current")):
            component.read_status(part, measured(f"{phase}_{field}", capability))
            part.add_capability(capability)
        _count(component, part, data, f"{phase}_total_act_energy", f"{phase}_total_act_ret_energy")
        parts.append(part)
    return tuple(parts)


def _count(component: ShellyComponent, part: JsonPart, key: str, drawn: str, returned: str) -> None:
    """Have *part* tell the energy that the component *key* counts both ways."""
    for field, capability in ((drawn, "energy"), (returned, "energy_returned")):
        component.read_status(part, measured(field, capability, _ENERGY), key)
        part.add_capability(capability)


def _decode_energy(field: str, capability: str, status: Fields) -> Readings:
    energy = status.get(field)
    total = to_number(energy.get("total")) if isinstance(energy, dict) else None
    return NO_READINGS if total is None else {capability: total * _ENERGY}
