"""Guesses at what an undeclared property does, by its name and its format. Pure.

Source: the words and forms that Homie devices commonly use.
"""

from __future__ import annotations

from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.node_types import is_beside, is_setting, tokens_in

__all__ = ["guess_role", "is_moving", "is_opening", "is_speed"]


def guess_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
    """Return the role of a property, one of :data:`homebot.conventions.homie.roles.CONTROLS` or ``press``.

    Args:
        node: The node that has it.
        prop: The property.
        kind: The node's kind; empty where there is no hint.
        tokens: Of the property's id and name.

    Returns:
        Its role; empty where there is no hint.
    """
    return _settable_role(node, prop, kind, tokens) if prop.is_settable else _reported_role(node, prop, kind, tokens)


def is_opening(prop: HomieProperty) -> bool:
    """Return whether it reports how something opens and closes."""
    return prop.datatype == "enum" and {one.casefold() for one in prop.options} <= _OPENINGS


def is_moving(prop: HomieProperty) -> bool:
    """Return whether it takes commands to open and to close."""
    options = {one.casefold() for one in prop.options}
    return prop.datatype == "enum" and bool(options & {"open", "up"}) and bool(options & {"close", "closed", "down"})


def is_speed(prop: HomieProperty) -> bool:
    """Return whether its words are speeds of something that can stand still."""
    options = {one.casefold() for one in prop.options}
    return prop.datatype == "enum" and not _STANDING.isdisjoint(options) and not is_moving(prop)


_SWITCHING = frozenset({"power", "on", "onoff", "state", "switch", "relay", "value"})
_LOCKING = frozenset({"lock", "locked", "bolt", "latch", "state", "value"})
_FLOWING = frozenset({"valve", "open", "opened", *_SWITCHING})
_OF_VALVES = frozenset({"water"})
_SPEEDS = frozenset({"speed", "fan", "ventilator", "ventilation", "level", "mode", "preset", "stage", "state", "value"})
_POSITIONS = frozenset(
    {"position", "opening", "percentage", "level", "value", "shutter", "blind", "cover", "curtain", "awning"}
)
_TILTS = frozenset({"tilt", "slat", "slats"})
_BRIGHT = frozenset({"brightness", "dim", "dimmer"})
_LEVELS = frozenset({*_BRIGHT, "level", "intensity"})
_SETPOINTS = frozenset({"setpoint", "heatsetpoint", "coolsetpoint", "target", "set", "temperature"})
_MODES = frozenset({"mode", "system-mode", "systemmode", "hvac-mode"})
_THERMAL = frozenset({"off", "heat", "heating", "cool", "cooling", "auto", "manual", "dry", "fan_only", "heat_cool"})
_OPENINGS = frozenset({"open", "closed", "opening", "closing", "stopped", "close", "up", "down", "stop"})
_STANDING = frozenset({"off", "0", "stop", "stopped", "none"})
_WHITES = frozenset({"K", "MK⁻¹", "mired", "mireds"})
_CELSIUS = frozenset({"", "°C", "C"})
_FAHRENHEIT = frozenset({"°F", "F"})
_ENDS = frozenset({1.0, 100.0, 254.0, 255.0})
_LEAST_KELVIN = 1000.0


def _settable_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
    if is_setting(tokens_in(node.id, node.name)) or is_beside(tokens - _OF_VALVES if kind == "valve" else tokens):
        return ""
    if prop.datatype == "color":
        return "color" if kind in {"light", ""} else ""
    is_main = prop.id == node.id
    if prop.is_number:
        return _settable_number_role(node, prop, kind, tokens)
    if prop.datatype == "boolean":
        return _settable_flag_role(kind, tokens, is_main=is_main)
    return _settable_enum_role(prop, kind, tokens, is_main=is_main) if prop.datatype == "enum" else ""


def _settable_flag_role(kind: str, tokens: frozenset[str], *, is_main: bool) -> str:
    if kind == "lock":
        return "lock" if tokens & _LOCKING or is_main else ""
    if kind == "valve":
        return "valve" if tokens & _FLOWING or is_main else ""
    return "on_off" if tokens & _SWITCHING or is_main else ""


def _settable_number_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
    if kind == "thermostat":
        if not tokens & _SETPOINTS or not _is_room_temperature(prop):
            return ""
        return "cooling_setpoint" if any(token.startswith("cool") for token in tokens) else "heating_setpoint"
    if kind in {"shutter", "garage-door"} or (not kind and "position" in tokens):
        if tokens & _TILTS:
            return "tilt"
        return "position" if (tokens & _POSITIONS or prop.id == node.id) and _is_fraction(prop) else ""
    if kind == "fan":
        return "fan_speed" if (tokens & _SPEEDS or prop.id == node.id) and _is_speed_range(prop) else ""
    if kind not in {"light", ""}:
        return ""
    if prop.unit in _WHITES:
        is_white = prop.unit != "K" or prop.range.most is None or prop.range.most > _LEAST_KELVIN
        return "color_temperature" if is_white else ""
    about = _LEVELS if kind == "light" or tokens_in(node.id, node.type) & _LEVELS else _BRIGHT
    return "level" if tokens & about and _is_fraction(prop) and prop.range.most is not None else ""


def _is_fraction(prop: HomieProperty) -> bool:
    """Return whether its range is a part of a whole: it begins at 0 or 1, and ends where percent and bytes do."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0, 1.0} and prop.range.most in {None, *_ENDS}


def _is_speed_range(prop: HomieProperty) -> bool:
    """Return whether its numbers are percent or steps, of which 0 is standing still."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0} and (prop.range.most or 0.0) <= max(_ENDS)


def _is_room_temperature(prop: HomieProperty) -> bool:
    """Return whether it may be 20 °C: offsets and hystereses may not."""
    unit = prop.unit.strip()
    return (unit in _CELSIUS and prop.range.holds(20.0)) or (unit in _FAHRENHEIT and prop.range.holds(68.0))


def _settable_enum_role(prop: HomieProperty, kind: str, tokens: frozenset[str], *, is_main: bool) -> str:
    options = {one.casefold() for one in prop.options}
    if kind == "fan":
        return "fan_mode" if tokens & _SPEEDS or is_main else ""
    if kind == "thermostat" and tokens & {"fan", "fanmode"}:
        return "fan_mode"
    if kind == "thermostat" and prop.id in _MODES and options & _THERMAL:
        return "thermostat_mode"
    if kind in {"shutter", "garage-door"} and is_moving(prop):
        return "move"
    return "lock_action" if kind == "lock" and {"lock", "unlock"} <= options else ""


def _reported_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
    if kind == "thermostat" and prop.is_number and "temperature" in tokens and not is_beside(tokens):
        return "local_temperature"
    if kind in {"shutter", "garage-door"} and is_opening(prop) and is_moving(prop):
        return "movement"
    if kind == "lock" and prop.datatype == "boolean" and not is_beside(tokens):
        return "lock" if tokens & _LOCKING or prop.id == node.id else ""
    return "press" if prop.datatype == "boolean" and tokens & {"button", "doorbell"} else ""
