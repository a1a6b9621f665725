"""Switches, covers, thermostats, diffusers and lamps of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Switch, Cover, Thermostat, Cury, Light, CCT, RGB, RGBW and RGBCCT;
``transition_duration`` is in seconds. aioshelly, ``cury_set`` and ``ledstrip_set``; Home Assistant core 2026.11,
``components/shelly/light.py``: a strip is ``on``, and has effects.
"""

import math
from collections.abc import Mapping
from functools import partial

from homebot.conventions.command_values import Writer, number_writer, option_writer, percent_writer
from homebot.conventions.description import Publications
from homebot.conventions.lamp import LIGHT_CAPABILITIES, LightCommand, LightFeatures, WhiteRange, read_lamp, read_rgb
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import Readings, as_fields, percent_of, text_of
from homebot.devices.value import PlainValue
from homebot.integrations.shelly.formats.gen2_component import ShellyComponent
from homebot.integrations.shelly.formats.status import Fields, reader_of, texts_of
from homebot.support.numbers import to_number

_MOVEMENTS = ("open", "closed", "opening", "closing", "stopped")
_COMMANDS = {"open": "Cover.Open", "closed": "Cover.Close", "stopped": "Cover.Stop"}
_PERCENT = (0.0, 100.0)
_THERMOSTAT_BOUNDS = (5.0, 35.0)


def build_switch(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a relay: a light if the user's settings name one as its load, or a plug if it is a socket."""
    is_light = component.load.startswith("light")
    part = component.part("", "light" if is_light else "plug" if component.topics.is_plug else "switch")
    component.add_value(part, "on_off", "output", "Switch.Set", "on")
    return (part,)


def build_cover(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a cover. It has a position once it is calibrated, and a tilt if it has slats."""
    part = component.part("", "window_covering")
    component.read_status(part, _decode_cover)
    mover = option_writer("movement", _COMMANDS, lambda movement: component.call(_COMMANDS[movement]))
    part.add_capability("movement", writer=mover, options=_MOVEMENTS)
    if component.status.get("pos_control") is not False:
        part.add_capability("position", writer=_position_writer(component, "position", "pos"))
    slat = as_fields(component.config.get("slat"))
    if component.status.get("slat_pos") is not None or slat.get("enable") is True:
        part.add_capability("tilt", writer=_position_writer(component, "tilt", "slat_pos"))
    return (part,)


def _position_writer(component: ShellyComponent, capability: str, param: str) -> Writer:
    return percent_writer(capability, lambda percent: component.call("Cover.GoToPosition", **{param: round(percent)}))


def build_thermostat(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe the thermostat of a wall display: it heats, or cools if it is configured to."""
    mode, action = ("cool", "cooling") if component.config.get("type") == "cooling" else ("heat", "heating")
    setpoint, modes = f"{action}_setpoint", ("off", mode)

    def configure(**fields: object) -> Publications:
        return component.call("Thermostat.SetConfig", config=fields)

    part = component.part("", "thermostat")
    component.read_status(part, reader_of("target_C", setpoint))
    component.read_status(part, partial(_decode_thermostat, mode, action))
    target_writer = number_writer(
        setpoint, _THERMOSTAT_BOUNDS, "°C", lambda celsius: configure(target_C=round(celsius, 1))
    )
    part.add_capability(setpoint, writer=target_writer, bounds=_THERMOSTAT_BOUNDS)
    component.add_value(part, "local_temperature", "current_C")
    mode_writer = option_writer("thermostat_mode", modes, lambda chosen: configure(enable=chosen == mode))
    part.add_capability("thermostat_mode", writer=mode_writer, options=modes)
    part.add_capability("thermostat_action", options=(action, "idle"))
    return (part,)


def build_diffuser(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe the slots of a diffuser of two scents: switch, intensity, and what is left in the vial."""
    return tuple(part for slot in ("left", "right") for part in _build_slot(component, slot))


def _build_slot(component: ShellyComponent, slot: str) -> tuple[JsonPart, ...]:
    path = f"slots.{slot}"
    switch = component.part(slot, "switch", name=slot)
    component.add_value(switch, "on_off", f"{path}.on", "Cury.Set", "on", slot=slot)
    intensity = component.part(f"{slot}/intensity", "x_setting", name=f"{slot} intensity", category="config")
    component.add_value(
        intensity, "number", f"{path}.intensity", "Cury.Set", "intensity", unit="%", bounds=_PERCENT, slot=slot
    )
    vial = component.part(f"{slot}/vial", "x_sensor", name=f"{slot} vial", category="diagnostic")
    component.add_value(vial, "measurement", f"{path}.vial.level", unit="%")
    return switch, intensity, vial


def _decode_cover(status: Fields) -> Readings:
    readings: dict[str, PlainValue] = {}
    if (state := status.get("state")) in _MOVEMENTS or state == "calibrating":
        readings["movement"] = None if state == "calibrating" else str(state)
    for field, capability in (("current_pos", "position"), ("slat_pos", "tilt")):
        if field in status:
            readings[capability] = percent_of(status[field])
    return readings


def _decode_thermostat(mode: str, action: str, status: Fields) -> Readings:
    readings: dict[str, PlainValue] = {}
    enable, output = status.get("enable"), status.get("output")
    if isinstance(enable, bool):
        readings["thermostat_mode"] = mode if enable else "off"
    if isinstance(output, bool):
        readings["thermostat_action"] = action if output else "idle"
    return readings


_ANY_WHITE = (2700, 6500)
_MIN_TRANSITION_S = 0.5
_STRIP = "ledstrip"
_CALLED: Mapping[str, str] = {"light": "Light", _STRIP: "LedStrip"}
"""The names of components in methods; others are in capitals."""


LIGHTS: Mapping[str, frozenset[str]] = {
    "light": frozenset({"brightness"}),
    "cct": frozenset({"color_temp"}),
    "rgb": frozenset({"rgb"}),
    "rgbw": frozenset({"rgb"}),
    "rgbcct": frozenset({"color_temp", "rgb"}),
    _STRIP: frozenset({"rgb"}),
}
"""Modes of the components that are lamps; one with several has to be told which."""


def build_light(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a lamp."""
    white = _white_range(component.config)
    features = LightFeatures(
        LIGHTS[component.kind],
        WhiteRange(white, tuple(map(float, white))),
        texts_of(component.config.get("effects")),
        only_in_bounds=True,
        most_seconds=math.inf,
    )
    part = component.part("", "light")
    component.read_status(part, partial(_decode_light, features, "on" if component.kind == _STRIP else "output"))
    features.add_to(part, LIGHT_CAPABILITIES, partial(_set_light, component))
    return (part,)


def _decode_light(features: LightFeatures, on_key: str, status: Fields) -> Readings:
    readings = dict(read_lamp(status, on_key, "brightness"))
    if (effect := text_of(status.get("effect"))) in features.effects:
        readings["effect"] = effect
    mode = status.get("mode")
    if features.has_white and (kelvin := to_number(status.get("ct"))) is not None:
        readings["color_temperature"] = kelvin if kelvin > 0 and mode != "rgb" else None
    rgb = status.get("rgb")
    if features.color_mode and isinstance(rgb, list) and (color := read_rgb(rgb)) is not None:
        readings["color"] = color if mode != "cct" else None
    return readings


def _set_light(component: ShellyComponent, command: LightCommand) -> Publications:
    params: dict[str, object] = {"on": command.on}
    has_modes = len(LIGHTS[component.kind]) > 1
    if command.percent is not None:
        params["brightness"] = command.percent
    if command.white is not None:
        params |= ({"mode": "cct"} if has_modes else {}) | {"ct": round(command.white)}
    if command.color:
        params |= ({"mode": "rgb"} if has_modes else {}) | {"rgb": list(command.color)}
        params |= {"white": 0} if component.kind == "rgbw" else {}
    if command.effect:
        params["effect"] = command.effect
    if command.transition and component.kind != _STRIP:
        params["transition_duration"] = max(_MIN_TRANSITION_S, round(command.transition, 1))
    return component.call(f"{_CALLED.get(component.kind, component.kind.upper())}.Set", **params)


def _white_range(config: Fields) -> tuple[int, int]:
    bounds = config.get("ct_range")
    if isinstance(bounds, list) and len(bounds) == 2:
        warmest, coldest = map(to_number, bounds)
        if warmest is not None and coldest is not None and 1000 <= warmest < coldest <= 40_000:
            return round(warmest), round(coldest)
    return _ANY_WHITE
