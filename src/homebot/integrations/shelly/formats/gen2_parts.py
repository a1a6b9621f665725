"""Parts of Shelly's second generation: switches, covers, thermostats, lamps, sensors, meters and inputs. Pure.

Source: Shelly Gen2+ API, components Switch, Cover, Thermostat, Cury, Light, CCT, RGB, RGBW, RGBCCT, Temperature,
Humidity, Illuminance, DevicePower, Smoke, Flood, Presence, Voltmeter, Input, PM1, EM, EM1, EMData and EM1Data;
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
from homebot.conventions.probe_errors import DS18X20_RESET, read_probe
from homebot.conventions.units import sensor_type
from homebot.devices.value import PlainValue
from homebot.integrations.shelly.formats.gen2_component import MAX_UNIT_CHARACTERS, PRESSES, ShellyComponent
from homebot.integrations.shelly.formats.status import Fields, StatusDecoder, reader_of, texts_of
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
    parts: list[JsonPart] = []
    for slot in ("left", "right"):
        path = f"slots.{slot}"
        switch = component.part(slot, "switch", name=slot)
        component.add_value(switch, "on_off", f"{path}.on", "Cury.Set", "on", slot=slot)
        intensity = component.part(f"{slot}/intensity", "x_setting", name=f"{slot} intensity", category="config")
        component.add_value(
            intensity, "number", f"{path}.intensity", "Cury.Set", "intensity", unit="%", bounds=_PERCENT, slot=slot
        )
        vial = component.part(f"{slot}/vial", "x_sensor", name=f"{slot} vial", category="diagnostic")
        component.add_value(vial, "measurement", f"{path}.vial.level", unit="%")
        parts += (switch, intensity, vial)
    return tuple(parts)


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
        most_seconds=0.0 if component.kind == _STRIP else math.inf,
    )
    part = component.part("", "light")
    component.read_status(part, partial(_decode_light, features, "on" if component.kind == _STRIP else "output"))
    features.add_to(part, LIGHT_CAPABILITIES, partial(_set_light, component))
    return (part,)


def _decode_light(features: LightFeatures, on_key: str, status: Fields) -> Readings:
    readings = dict(read_lamp(status, on_key, "brightness"))
    if (effect := text_of(status.get("effect"))) in features.effects:
        readings["effect"] = effect
    if features.has_white and (kelvin := to_number(status.get("ct"))) is not None:
        readings["color_temperature"] = kelvin if kelvin > 0 else None
    rgb = status.get("rgb")
    if features.color_mode and isinstance(rgb, list) and (color := read_rgb(rgb)) is not None:
        readings["color"] = color
    mode = _COLOR_MODES.get(text_of(status.get("mode")))
    return readings if mode is None else {**readings, **features.absent_in(mode)}


_COLOR_MODES: Mapping[str, str] = {"cct": "color_temp", "rgb": "rgb"}


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
    if command.transition:
        params["transition_duration"] = max(_MIN_TRANSITION_S, round(command.transition, 1))
    return component.call(f"{_CALLED.get(component.kind, component.kind.upper())}.Set", **params)


def _white_range(config: Fields) -> tuple[int, int]:
    bounds = config.get("ct_range")
    if isinstance(bounds, list) and len(bounds) == 2:
        warmest, coldest = map(to_number, bounds)
        if warmest is not None and coldest is not None and 1000 <= warmest < coldest <= 40_000:
            return round(warmest), round(coldest)
    return _ANY_WHITE


Parts = tuple[JsonPart, ...]

SENSORS: Mapping[str, tuple[str, str]] = {
    "smoke": ("alarm", "smoke"),
    "flood": ("alarm", "water_leak"),
    "presencezone": ("state", "occupancy"),
    "temperature": ("tC", "temperature"),
    "humidity": ("rh", "humidity"),
    "illuminance": ("lux", "illuminance"),
    "voltmeter": ("voltage", "voltage"),
    "cb": ("output", "power_detected"),  # a circuit breaker, which no app may turn off
}
"""Field and capability of the components that are one sensor each."""

_WATT_HOURS = 1 / 1000
"""Factor from Shelly's watt-hours."""

_ELECTRICAL = (
    ("apower", "power"),
    ("act_power", "power"),
    ("voltage", "voltage"),
    ("current", "current"),
    ("freq", "frequency"),
)
_COUNTED = (("aenergy", "energy"), ("ret_aenergy", "energy_returned"))
_PHASES = ("a", "b", "c")
_PHASE = (("act_power", "power"), ("voltage", "voltage"), ("current", "current"), ("freq", "frequency"))


def build_sensor(component: ShellyComponent) -> Parts:
    """Describe a component that is one sensor."""
    field, capability = SENSORS[component.kind]
    if component.kind == "illuminance" and field not in component.status and "illumination" in component.status:
        field, capability = "illumination", "value"
    if component.kind == "presencezone" and "value" in component.status:
        field = "value"  # from firmware 1.8 on
    tag = "presence" if component.kind == "presencezone" else ""
    part = component.part("", sensor_type(capability), category="diagnostic" if component.is_inside else "", tag=tag)
    is_probe = component.kind == "temperature" and component.index in _OF_ADD_ON
    component.read_status(part, partial(_decode_sensor, reader_of(field, capability), capability, is_probe=is_probe))
    part.add_capability(capability)
    return (part,)


_OF_ADD_ON = range(100, 200)
"""Numbers of components that an add-on measures."""


def _decode_sensor(read: StatusDecoder, capability: str, status: Fields, *, is_probe: bool) -> Readings:
    """Read a sensor; the number beside an error is invalid: a display without sensor reports -275 °C."""
    if status.get("errors"):
        return {capability: None}
    return read_probe(read(status), DS18X20_RESET) if is_probe else read(status)


_FURTHER: Mapping[str, tuple[tuple[str, str, str], ...]] = {
    "presencezone": (("num_objects", "objects", ""),),
    "voltmeter": (("xvoltage", "value", "xvoltage"),),
    "input": (
        ("xpercent", "value", "xpercent"),
        ("counts.xtotal", "value", "xcounts"),
        ("freq", "frequency", ""),
        ("xfreq", "rate", "xfreq"),
    ),
}
"""Path and name of further values by kind, and the formula of the owner by which they are calculated, with its unit."""


def build_further(component: ShellyComponent) -> Parts:
    """Describe the further values that the component reports."""
    parts: list[JsonPart] = []
    for path, name, formula in _FURTHER.get(component.kind, ()):
        if component.has(path):
            part = component.part(path, "x_sensor", name=name)
            unit = text_of(as_fields(component.config.get(formula)).get("unit"), MAX_UNIT_CHARACTERS)
            component.add_value(part, "measurement", path, unit=unit or ("Hz" if path == "freq" else ""))
            parts.append(part)
    return tuple(parts)


def build_power(component: ShellyComponent) -> Parts:
    """Describe a battery, if the device has one, and whether it is plugged in."""
    status = component.status
    part = component.part("", "x_battery", category="diagnostic")
    if "battery" in status or "external" not in status:
        component.add_value(part, "battery", "battery.percent")
    if "V" in as_fields(status.get("battery")):
        component.add_value(part, "voltage", "battery.V")
    if isinstance(status.get("external"), dict):
        component.add_value(part, "plugged_in", "external.present")
    return (part,)


def build_input(component: ShellyComponent) -> Parts:
    """Describe an input: a button, a switch, an analogue value or a counter, as it is configured."""
    kind, status = component.config.get("type"), component.status
    if component.config.get("enable") is False:
        return ()
    if kind == "analog" or (kind is None and "percent" in status and "state" not in status):
        return _build_measured_input(component, "percent", "%")
    if kind == "count":
        return _build_measured_input(component, "counts.total", "")
    is_button = kind != "switch"
    part = component.part("", "generic_switch" if is_button else "x_binary_sensor")
    if not is_button or component.status.get("state") is not None:
        component.add_value(part, "state", "state")
    if is_button:
        component.add_presses(part, PRESSES)
    return (part,)


def _build_measured_input(component: ShellyComponent, path: str, unit: str) -> Parts:
    part = component.part("", "x_sensor")
    component.add_value(part, "measurement", path, unit=unit)
    return (part,)


def build_meters(component: ShellyComponent) -> Parts:
    """Describe the electrical measurements of a component; none for one that has none."""
    if component.kind == "em":
        return _build_phases(component)
    is_meter = component.kind in {"pm1", "em1"}
    if not is_meter and "apower" not in component.status:
        return ()
    part = component.part("" if is_meter else "meter", "electrical_meter")
    for field, capability in _ELECTRICAL:
        if field in component.status:
            component.add_value(part, capability, field)
    for field, capability in _COUNTED:
        if isinstance(component.status.get(field), dict):
            component.add_value(part, capability, f"{field}.total", factor=_WATT_HOURS)
    if component.kind == "em1":
        _add_counters(component, part, f"em1data:{component.index}", "total_act_energy", "total_act_ret_energy")
    return (part,)


def _build_phases(component: ShellyComponent) -> Parts:
    data = f"emdata:{component.index}"
    total = component.part("", "electrical_meter")
    for field, capability in (("total_act_power", "power"), ("total_current", "current")):
        component.add_value(total, capability, field)
    _add_counters(component, total, data, "total_act", "total_act_ret")
    parts = [total]
    for phase in _PHASES:
        if f"{phase}_act_power" not in component.status:
            continue
        part = component.part(phase, "electrical_meter", tag=f"phase_{phase}")
        for field, capability in _PHASE:
            if field == "act_power" or component.has(f"{phase}_{field}"):
                component.add_value(part, capability, f"{phase}_{field}")
        _add_counters(component, part, data, f"{phase}_total_act_energy", f"{phase}_total_act_ret_energy")
        parts.append(part)
    return tuple(parts)


def _add_counters(component: ShellyComponent, part: JsonPart, key: str, drawn: str, returned: str) -> None:
    """Add the energy that the component *key* counts in both directions."""
    component.add_value(part, "energy", drawn, factor=_WATT_HOURS, key=key)
    component.add_value(part, "energy_returned", returned, factor=_WATT_HOURS, key=key)


def build_own_temperature(component: ShellyComponent) -> Parts:
    """Describe the temperature of the device itself, if the component reports it."""
    if not isinstance(component.status.get("temperature"), dict):
        return ()
    part = component.part("temperature", "temperature_sensor", category="diagnostic")
    component.add_value(part, "temperature", "temperature.tC")
    return (part,)
