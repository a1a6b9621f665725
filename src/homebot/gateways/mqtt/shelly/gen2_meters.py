"""What Shelly's second generation measures of the electricity through it, and its own heat. Pure.

Source: Shelly Gen2+ API, components PM1, EM, EM1, EMData, EM1Data, and the measurements of Switch, Cover and Light.
"""

from __future__ import annotations

from homebot.gateways.mqtt.part_table import JsonPart
from homebot.gateways.mqtt.readings import NOTHING, Readings, number_in
from homebot.gateways.mqtt.shelly.gen2_component import Component, Fields, measured

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
_PHASES = ("a", "b", "c")
_TOTALS = (("total_act_power", "power"), ("total_current", "current"))


def build_meters(component: Component) -> tuple[JsonPart, ...]:
    """Describe what a component measures of the electricity through it; nothing where it does not."""
    if component.kind == "em":
        return _build_phases(component)
    is_meter = component.kind in {"pm1", "em1"}
    if not is_meter and "apower" not in component.status:
        return ()
    part = component.part("" if is_meter else "meter", "electrical_meter")
    for field, capability in _ELECTRICAL:
        if field in component.status:
            component.tells(part, measured(field, capability))
            part.offers(capability)
    if isinstance(component.status.get("aenergy"), dict):
        component.tells(part, _told_energy)
        part.offers("energy")
    if component.kind == "em1":
        component.tells(part, measured("total_act_energy", "energy", _ENERGY), f"em1data:{component.index}")
        part.offers("energy")
    return (part,)


def build_own_temperature(component: Component) -> tuple[JsonPart, ...]:
    """Describe how warm the device itself is, where the component tells."""
    if not isinstance(component.status.get("temperature"), dict):
        return ()
    inner = measured("tC", "temperature")

    def told(status: Fields) -> Readings:
        temperature = status.get("temperature")
        return inner(temperature) if isinstance(temperature, dict) else NOTHING

    part = component.part("temperature", "temperature_sensor", category="diagnostic")
    component.tells(part, told)
    part.offers("temperature")
    return (part,)


def _build_phases(component: Component) -> tuple[JsonPart, ...]:
    total = component.part("", "electrical_meter")
    for field, capability in _TOTALS:
        component.tells(total, measured(field, capability))
        total.offers(capability)
    data = f"emdata:{component.index}"
    component.tells(total, measured("total_act", "energy", _ENERGY), data)
    total.offers("energy")
    parts = [total]
    for phase in _PHASES:
        if f"{phase}_act_power" not in component.status:
            continue
        part = component.part(phase, "electrical_meter", tag=f"phase_{phase}")
        for field, capability in (("act_power", "power"), ("voltage", "voltage"), ("current", "current")):
            component.tells(part, measured(f"{phase}_{field}", capability))
            part.offers(capability)
        component.tells(part, measured(f"{phase}_total_act_energy", "energy", _ENERGY), data)
        part.offers("energy")
        parts.append(part)
    return tuple(parts)


def _told_energy(status: Fields) -> Readings:
    energy = status.get("aenergy")
    total = number_in(energy.get("total")) if isinstance(energy, dict) else None
    return NOTHING if total is None else {"energy": total * _ENERGY}
