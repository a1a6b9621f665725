"""Switches, covers, thermostats and lamps of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Switch, Cover, Thermostat, BluTrv, Light, CCT, RGB, RGBW and RGBCCT;
``transition_duration`` is in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import (
    Writer,
    bool_writer,
    number_writer,
    option_writer,
    require_bool,
    require_color,
    require_number,
)
from homebot.conventions.description import Publications
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import Readings, as_fields, percent_of
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent, flag, measured
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["LIGHTS", "build_cover", "build_light", "build_radiator_valve", "build_switch", "build_thermostat"]


_MOVEMENTS = ("open", "closed", "opening", "closing", "stopped")
_COMMANDS = {"open": "Cover.Open", "closed": "Cover.Close", "stopped": "Cover.Stop"}
_PERCENT = (0.0, 100.0)
_THERMOSTAT_BOUNDS = (5.0, 35.0)
_VALVE_BOUNDS = (4.0, 30.0)


def build_switch(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a relay: a light where people say that it feeds one, else a plug where it is a socket."""
    is_light = component.load.startswith("light")
    part = component.part("", "light" if is_light else "plug" if component.topics.is_plug else "switch")
    component.read_status(part, flag("output", "on_off"))
    component.add_command_topic(part)
    writer = bool_writer("on_off", lambda on: component.call("Switch.Set", on=on))
    part.add_capability("on_off", writer=writer)
    return (part,)


def build_cover(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a cover. Its position is known and settable once it is calibrated, its slats where it has some."""
    part = component.part("", "window_covering")
    component.read_status(part, _decode_cover)
    component.add_command_topic(part)
    mover = option_writer("movement", _COMMANDS, lambda movement: component.call(_COMMANDS[movement]))
    part.add_capability("movement", writer=mover, options=_MOVEMENTS)
    if component.status.get("pos_control") is not False:
        part.add_capability("position", writer=_go_to(component, "position", "pos"))
    slat = as_fields(component.config.get("slat"))
    if component.status.get("slat_pos") is not None or slat.get("enable") is True:
        part.add_capability("tilt", writer=_go_to(component, "tilt", "slat_pos"))
    return (part,)


def _go_to(component: ShellyComponent, capability: str, param: str) -> Writer:
    return number_writer(
        capability, _PERCENT, "%", lambda percent: component.call("Cover.GoToPosition", **{param: round(percent)})
    )


def build_thermostat(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe the thermostat of a wall display: it heats, or cools where it is set up to."""
    work = _COOLING if component.config.get("type") == "cooling" else _HEATING

    def aim(celsius: float) -> Publications:
        return component.call("Thermostat.SetConfig", config={"target_C": round(celsius, 1)})

    def choose(mode: str) -> Publications:
        return component.call("Thermostat.SetConfig", config={"enable": mode == work.mode})

    modes = ("off", work.mode)
    part = component.part("", "thermostat")
    component.read_status(part, partial(_decode_thermostat, work))
    component.add_command_topic(part)
    writer = number_writer(work.setpoint, _THERMOSTAT_BOUNDS, "°C", aim)
    part.add_capability(work.setpoint, writer=writer, bounds=_THERMOSTAT_BOUNDS)
    part.add_capability("local_temperature")
    part.add_capability("thermostat_mode", writer=option_writer("thermostat_mode", modes, choose), options=modes)
    part.add_capability("thermostat_action", options=(work.action, "idle"))
    return (part,)


@dataclass(frozen=True, slots=True)
class _ThermalWork:
    mode: str
    action: str
    setpoint: str


_HEATING = _ThermalWork("heat", "heating", "heating_setpoint")
_COOLING = _ThermalWork("cool", "cooling", "cooling_setpoint")


def build_radiator_valve(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a radiator valve that a gateway reaches by Bluetooth."""

    def heat(celsius: float) -> Publications:
        params = {"id": 0, "target_C": round(celsius, 1)}
        return component.call("BluTRV.Call", method="TRV.SetTarget", params=params)

    part = component.part("", "thermostat", tag="radiator_valve")
    component.read_status(part, measured("target_C", "heating_setpoint"))
    component.add_command_topic(part)
    writer = number_writer("heating_setpoint", _VALVE_BOUNDS, "°C", heat)
    part.add_capability("heating_setpoint", writer=writer, bounds=_VALVE_BOUNDS)
    component.add_measure(part, "current_C", "local_temperature")
    component.add_measure(part, "pos", "position")
    battery = component.part("battery", "x_battery", category="diagnostic")
    component.add_measure(battery, "battery", "battery")
    return part, battery


def _decode_cover(status: Fields) -> Readings:
    found: dict[str, PlainValue] = {}
    if (state := status.get("state")) in _MOVEMENTS or state == "calibrating":
        found["movement"] = None if state == "calibrating" else str(state)
    for field, capability in (("current_pos", "position"), ("slat_pos", "tilt")):
        if field in status:
            found[capability] = percent_of(status[field])
    return found


def _decode_thermostat(work: _ThermalWork, status: Fields) -> Readings:
    found = {
        **measured("target_C", work.setpoint)(status),
        **measured("current_C", "local_temperature")(status),
    }
    enable, output = status.get("enable"), status.get("output")
    if isinstance(enable, bool):
        found["thermostat_mode"] = work.mode if enable else "off"
    if isinstance(output, bool):
        found["thermostat_action"] = work.action if output else "idle"
    return found


_ANY_WHITE = (2700, 6500)
_LEAST_TRANSITION = 0.5
_CHANNELS = 3


@dataclass(frozen=True, slots=True)
class _LightKind:
    namespace: str
    has_white: bool = False
    has_color: bool = False
    modes: tuple[str, str] | None = None


LIGHTS: Mapping[str, _LightKind] = {
    "light": _LightKind("Light"),
    "cct": _LightKind("CCT", has_white=True),
    "rgb": _LightKind("RGB", has_color=True),
    "rgbw": _LightKind("RGBW", has_color=True),
    "rgbcct": _LightKind("RGBCCT", has_white=True, has_color=True, modes=("cct", "rgb")),
}
"""The components that are lamps."""


def build_light(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a lamp."""
    lamp = _Gen2Lamp(component, LIGHTS[component.kind], _white_range(component.config))
    part = component.part("", "light")
    component.read_status(part, lamp.decode)
    component.add_command_topic(part)
    part.add_capability("on_off", writer=lamp.switch)
    part.add_capability("level", writer=lamp.dim)
    if lamp.kind.has_white:
        part.add_capability("color_temperature", writer=lamp.warm, bounds=tuple(map(float, lamp.white)))
    if lamp.kind.has_color:
        part.add_capability("color", writer=lamp.paint)
    return (part,)


@dataclass(frozen=True, slots=True)
class _Gen2Lamp:
    component: ShellyComponent
    kind: _LightKind
    white: tuple[int, int]

    def decode(self, status: Fields) -> Readings:
        found: dict[str, PlainValue] = {}
        if isinstance(on := status.get("output"), bool):
            found["on_off"] = on
        level = to_number(status.get("brightness"))
        if level is not None and 0 <= level <= 100:
            found["level"] = level
        mode = status.get("mode")
        if self.kind.has_white and (kelvin := to_number(status.get("ct"))) is not None:
            found["color_temperature"] = kelvin if kelvin > 0 and mode != "rgb" else None
        if self.kind.has_color and (rgb := _rgb(status.get("rgb"))) is not None:
            found["color"] = to_hue_saturation("rgb", rgb, _ANY_WHITE) if mode != "cct" else None
        return found

    def switch(self, value: PlainValue, transition: float) -> Publications:
        return self._set(transition, on=require_bool("on_off", value))

    def dim(self, value: PlainValue, transition: float) -> Publications:
        level = require_number("level", value, 0, 100, "%")
        if level == 0:
            return self._set(transition, on=False)
        return self._set(transition, on=True, brightness=max(1, round(level)))

    def warm(self, value: PlainValue, transition: float) -> Publications:
        kelvin = round(require_number("color_temperature", value, *self.white, "K"))
        mode = {} if self.kind.modes is None else {"mode": self.kind.modes[0]}
        return self._set(transition, on=True, **mode, ct=kelvin)

    def paint(self, value: PlainValue, transition: float) -> Publications:
        hue, saturation = require_color(value)
        rgb = [int(one) for one in from_hue_saturation("rgb", hue, saturation, _ANY_WHITE)]
        mode = {} if self.kind.modes is None else {"mode": self.kind.modes[1]}
        white = {"white": 0} if self.kind.namespace == "RGBW" else {}
        return self._set(transition, on=True, **mode, rgb=rgb, **white)

    def _set(self, transition: float, **params: object) -> Publications:
        if transition:
            params["transition_duration"] = max(_LEAST_TRANSITION, round(transition, 1))
        return self.component.call(f"{self.kind.namespace}.Set", **params)


def _rgb(value: object) -> tuple[float, ...] | None:
    if not isinstance(value, list) or len(value) != _CHANNELS:
        return None
    channels = tuple(one for one in map(to_number, value) if one is not None and 0 <= one <= 255)
    return channels if len(channels) == _CHANNELS else None


def _white_range(config: Fields) -> tuple[int, int]:
    bounds = config.get("ct_range")
    if isinstance(bounds, list) and len(bounds) == 2:
        warmest, coldest = (to_number(one) for one in bounds)
        if warmest is not None and coldest is not None and 1000 <= warmest < coldest <= 40_000:
            return round(warmest), round(coldest)
    return _ANY_WHITE
