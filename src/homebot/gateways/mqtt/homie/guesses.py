"""What a property that nobody declared seems to do, by its words and its form. Pure.

Source: the words and forms that Homie devices commonly use.
"""

from __future__ import annotations

from homebot.gateways.mqtt.homie.model import HomieNode, HomieProperty

__all__ = ["guess_role", "is_opening"]


def guess_role(node: HomieNode, prop: HomieProperty, kind: str, words: frozenset[str]) -> str:
    """Return the role of a property, one of :data:`homebot.gateways.mqtt.homie.roles.CONTROLS` or ``press``.

    Args:
        node: The node that has it.
        prop: The property.
        kind: The node's kind; empty where there is no hint.
        words: Of the property's id and name.

    Returns:
        Its role; empty where there is no hint.
    """
    return _ordered(node, prop, kind, words) if prop.is_settable else _watched(prop, kind, words)


def is_opening(prop: HomieProperty) -> bool:
    """Whether it tells how something opens and closes."""
    return prop.datatype == "enum" and {one.casefold() for one in prop.options} <= _OPENINGS


_SWITCHING = frozenset({"power", "on", "onoff", "state", "switch", "relay", "value"})
_LEVELS = frozenset({"brightness", "dim", "dimmer", "level", "intensity"})
_SETPOINTS = frozenset({"setpoint", "heatsetpoint", "coolsetpoint", "target", "set", "temperature"})
_MODES = frozenset({"mode", "system-mode", "systemmode", "hvac-mode"})
_OPENINGS = frozenset({"open", "closed", "opening", "closing", "stopped", "close", "up", "stop"})
_WHITES = frozenset({"K", "MK⁻¹", "mired", "mireds"})


def _ordered(node: HomieNode, prop: HomieProperty, kind: str, words: frozenset[str]) -> str:
    if prop.datatype == "color":
        return "color"
    if prop.is_number:
        return _ordered_number(prop, kind, words)
    if prop.datatype == "boolean":
        if kind in {"lock", "valve"}:
            return kind
        return "on_off" if words & _SWITCHING or prop.id == node.id else ""
    return _ordered_word(prop, kind, words) if prop.datatype == "enum" else ""


def _ordered_number(prop: HomieProperty, kind: str, words: frozenset[str]) -> str:
    if kind == "thermostat" and words & _SETPOINTS:
        return "cooling_setpoint" if any(word.startswith("cool") for word in words) else "heating_setpoint"
    if "position" in words or kind == "shutter":
        return "tilt" if words & {"tilt", "slat"} else "position"
    if prop.unit in _WHITES and kind in {"light", ""}:
        return "color_temperature"
    if words & _LEVELS and prop.range.most in {1.0, 100.0, 254.0, 255.0}:
        return "level"
    return ""


def _ordered_word(prop: HomieProperty, kind: str, words: frozenset[str]) -> str:
    options = {one.casefold() for one in prop.options}
    if kind == "fan" or (kind == "thermostat" and words & {"fan", "fanmode"}):
        return "fan_mode"
    if kind == "thermostat" and prop.id in _MODES:
        return "thermostat_mode"
    if kind in {"shutter", "garage-door"} and options & {"open", "up"}:
        return "move"
    return "lock_action" if kind == "lock" and options & {"lock", "unlock"} else ""


def _watched(prop: HomieProperty, kind: str, words: frozenset[str]) -> str:
    if kind == "thermostat" and prop.is_number and "temperature" in words:
        return "local_temperature"
    if kind in {"shutter", "garage-door"} and is_opening(prop):
        return "movement"
    if kind == "lock" and prop.datatype == "boolean":
        return "lock"
    return "press" if prop.datatype == "boolean" and words & {"button", "doorbell"} else ""
