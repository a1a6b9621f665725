"""Switches, covers and thermostats of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Switch, Cover, Thermostat and BluTrv.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent, flag, measured
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["build_cover", "build_radiator_valve", "build_switch", "build_thermostat"]

_MOVEMENTS: Mapping[str, Readings] = {
    "open": {"movement": "open"},
    "closed": {"movement": "closed"},
    "opening": {"movement": "opening"},
    "closing": {"movement": "closing"},
    "stopped": {"movement": "stopped"},
    "calibrating": {"movement": None},
}
_ORDERS = {"open": "Cover.Open", "closed": "Cover.Close", "stopped": "Cover.Stop"}
_THERMOSTAT_BOUNDS = (5.0, 35.0)
_VALVE_BOUNDS = (4.0, 30.0)
_MODES = ("off", "heat")


def build_switch(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a relay: a plug where it is a socket."""

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return component.call("Switch.Set", on=require_bool("on_off", value))

    part = component.part("", "plug" if component.topics.is_plug else "switch")
    component.read_status(part, flag("output", "on_off"))
    component.add_command_topic(part)
    part.add_capability("on_off", writer=write)
    return (part,)


def build_cover(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a cover. Its position is known and settable once it is calibrated, its slats where it has some."""

    def move(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return component.call(_ORDERS[require_option("movement", value, _ORDERS)])

    def go(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return component.call("Cover.GoToPosition", pos=round(require_number("position", value, 0, 100, "%")))

    def turn(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return component.call("Cover.GoToPosition", slat_pos=round(require_number("tilt", value, 0, 100, "%")))

    part = component.part("", "window_covering")
    component.read_status(part, _decode_cover)
    component.add_command_topic(part)
    part.add_capability("movement", writer=move, options=("open", "closed", "opening", "closing", "stopped"))
    if component.status.get("pos_control") is not False:
        part.add_capability("position", writer=go)
    slat = component.config.get("slat")
    if component.status.get("slat_pos") is not None or (isinstance(slat, dict) and slat.get("enable") is True):
        part.add_capability("tilt", writer=turn)
    return (part,)


def build_thermostat(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe the thermostat of a wall display."""

    def heat(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        celsius = round(require_number("heating_setpoint", value, *_THERMOSTAT_BOUNDS, "°C"), 1)
        return component.call("Thermostat.SetConfig", config={"target_C": celsius})

    def choose(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        enable = require_option("thermostat_mode", value, _MODES) == "heat"
        return component.call("Thermostat.SetConfig", config={"enable": enable})

    part = component.part("", "thermostat")
    component.read_status(part, _decode_thermostat)
    component.add_command_topic(part)
    part.add_capability("heating_setpoint", writer=heat, bounds=_THERMOSTAT_BOUNDS)
    part.add_capability("local_temperature")
    part.add_capability("thermostat_mode", writer=choose, options=_MODES)
    part.add_capability("thermostat_action", options=("heating", "idle"))
    return (part,)


def build_radiator_valve(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a radiator valve that a gateway reaches by Bluetooth."""

    def heat(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        celsius = round(require_number("heating_setpoint", value, *_VALVE_BOUNDS, "°C"), 1)
        return component.call("BluTRV.Call", method="TRV.SetTarget", params={"id": 0, "target_C": celsius})

    part = component.part("", "thermostat", tag="radiator_valve")
    for field, capability in (("target_C", "heating_setpoint"), ("current_C", "local_temperature")):
        component.read_status(part, measured(field, capability))
    component.read_status(part, measured("pos", "position"))
    component.add_command_topic(part)
    part.add_capability("heating_setpoint", writer=heat, bounds=_VALVE_BOUNDS)
    part.add_capability("local_temperature")
    part.add_capability("position")
    battery = component.part("battery", "x_battery", category="diagnostic")
    component.read_status(battery, measured("battery", "battery"))
    battery.add_capability("battery")
    return part, battery


def _decode_cover(status: Fields) -> Readings:
    state = status.get("state")
    found = dict(_MOVEMENTS.get(state, NO_READINGS)) if isinstance(state, str) else {}
    for field, capability in (("current_pos", "position"), ("slat_pos", "tilt")):
        if field in status:
            value = to_number(status[field])
            found[capability] = value if value is not None and 0 <= value <= 100 else None
    return found


def _decode_thermostat(status: Fields) -> Readings:
    found = {
        **measured("target_C", "heating_setpoint")(status),
        **measured("current_C", "local_temperature")(status),
    }
    enable, output = status.get("enable"), status.get("output")
    if isinstance(enable, bool):
        found["thermostat_mode"] = "heat" if enable else "off"
    if isinstance(output, bool):
        found["thermostat_action"] = "heating" if output else "idle"
    return found
