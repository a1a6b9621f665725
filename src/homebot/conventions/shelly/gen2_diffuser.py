"""Shelly Cury, a diffuser of two scents: a switch for each slot, its intensity, and what is left of its vial. Pure.

Source: Shelly Gen2+ API, Cury; aioshelly, ``cury_set``; Home Assistant core, the fixture ``cury_gen4.json``.
"""

from __future__ import annotations

from homebot.conventions.command_values import bool_writer, number_writer
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_component import ShellyComponent, flag, measured

__all__ = ["build_diffuser"]

_SLOTS = ("left", "right")
_PERCENT = (0.0, 100.0)


def build_diffuser(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe the slots of a diffuser."""
    return tuple(part for slot in _SLOTS for part in _build_slot(component, slot))


def _build_slot(component: ShellyComponent, slot: str) -> tuple[JsonPart, ...]:
    switch = component.part(slot, "switch", name=slot)
    component.read_status(switch, flag(f"slots.{slot}.on", "on_off"))
    component.add_command_topic(switch)
    writer = bool_writer("on_off", lambda on: component.call("Cury.Set", slot=slot, on=on))
    switch.add_capability("on_off", writer=writer)
    intensity = component.part(f"{slot}/intensity", "x_setting", name=f"{slot} intensity", category="config")
    component.read_status(intensity, measured(f"slots.{slot}.intensity", "number"))
    component.add_command_topic(intensity)
    setter = number_writer(
        "number", _PERCENT, "%", lambda percent: component.call("Cury.Set", slot=slot, intensity=round(percent))
    )
    intensity.add_capability("number", writer=setter, unit="%", bounds=_PERCENT)
    vial = component.part(f"{slot}/vial", "x_sensor", name=f"{slot} vial", category="diagnostic")
    component.add_measure(vial, f"slots.{slot}.vial.level", "measurement", unit="%")
    return switch, intensity, vial
