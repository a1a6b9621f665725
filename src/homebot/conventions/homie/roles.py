"""Roles of a node's properties: as its type declares, or as names and formats suggest. Pure.

Source: hc-smarthome v2; the words and forms that Homie devices commonly use.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.node_types import (
    KINDS,
    condition_of,
    declared_kind,
    guessed_kinds,
    is_beside,
    is_setting,
    quantity_of,
    tokens_in,
)

__all__ = ["CONTROLS", "THERMOSTAT_ROLES", "NodeRoles", "Role", "as_settings", "find_roles"]


def _guess_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
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


def _is_opening(prop: HomieProperty) -> bool:
    """Return whether it reports how something opens and closes."""
    return prop.datatype == "enum" and {one.casefold() for one in prop.options} <= _OPENINGS


def _is_moving(prop: HomieProperty) -> bool:
    """Return whether it takes commands to open and to close."""
    options = {one.casefold() for one in prop.options}
    return prop.datatype == "enum" and bool(options & {"open", "up"}) and bool(options & {"close", "closed", "down"})


def _is_speed(prop: HomieProperty) -> bool:
    """Return whether its words are speeds of something that can stand still."""
    options = {one.casefold() for one in prop.options}
    return prop.datatype == "enum" and not _STANDING.isdisjoint(options) and not _is_moving(prop)


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
    if kind in {"shutter", "garage-door"} and _is_moving(prop):
        return "move"
    return "lock_action" if kind == "lock" and {"lock", "unlock"} <= options else ""


def _reported_role(node: HomieNode, prop: HomieProperty, kind: str, tokens: frozenset[str]) -> str:
    if kind == "thermostat" and prop.is_number and "temperature" in tokens and not is_beside(tokens):
        return "local_temperature"
    if kind in {"shutter", "garage-door"} and _is_opening(prop) and _is_moving(prop):
        return "movement"
    if kind == "lock" and prop.datatype == "boolean" and not is_beside(tokens):
        return "lock" if tokens & _LOCKING or prop.id == node.id else ""
    return "press" if prop.datatype == "boolean" and tokens & {"button", "doorbell"} else ""


CONTROLS = frozenset(
    {"on_off", "level", "color", "color_temperature", "position", "tilt", "movement", "move", "lock", "lock_action"}
    | {"valve", "heating_setpoint", "cooling_setpoint", "thermostat_mode", "fan_mode", "fan_speed", "local_temperature"}
)
"""Roles of what a part is controlled by; every other role is a capability that it only reports."""

THERMOSTAT_ROLES = frozenset({"heating_setpoint", "cooling_setpoint", "thermostat_mode"})
"""Those of which a thermostat has at least one."""


@dataclass(frozen=True, slots=True)
class Role:
    """The role of a property.

    Attributes:
        name: One of :data:`CONTROLS`, or the capability that it reports; empty for a setting.
        prop: The property.
        is_guess: Whether its shape suggested it.
    """

    name: str
    prop: HomieProperty
    is_guess: bool


@dataclass(frozen=True, slots=True)
class NodeRoles:
    """The properties of a node by their roles.

    Attributes:
        node: The node.
        kind: Its kind; empty where there is no hint.
        is_guess: Whether the kind was guessed.
        roles: Of its properties.
    """

    node: HomieNode
    kind: str
    is_guess: bool
    roles: tuple[Role, ...]

    def prop(self, name: str) -> HomieProperty | None:
        """Return the first property with the role *name*."""
        return next((role.prop for role in self.roles if role.name == name), None)


def find_roles(node: HomieNode, around: frozenset[str]) -> NodeRoles:
    """Return what the properties of *node* do; the words of its device are *around* it."""
    declared = declared_kind(node.type)
    if declared:
        roles = _singled(node, (_declared_role(node, prop, declared) for prop in node.properties))
        return NodeRoles(node, declared, is_guess=False, roles=roles)
    kinds = guessed_kinds(node, around)
    for kind in kinds:
        roles = _singled(node, (_guessed_role(node, prop, kind) for prop in node.properties))
        if _is_borne_out(kind, {role.name: role.prop for role in roles}):
            return NodeRoles(node, kind, is_guess=True, roles=roles)
    roles = _singled(node, (_guessed_role(node, prop, "") for prop in node.properties))
    if kinds:
        roles = tuple(_read_only_role(node, role.prop, "") if role.name in _SHARES else role for role in roles)
    return NodeRoles(node, "", is_guess=True, roles=roles)


_SHARES = frozenset({"level", "position", "tilt"})
"""Roles that a number alone does not bear out where words suggest something else: the position of a valve."""


def as_settings(node: NodeRoles, without: tuple[HomieProperty, ...]) -> NodeRoles:
    """Return *node* so that what was guessed of it controls nothing, and without the given properties."""
    roles = [role for role in node.roles if role.prop not in without]
    if node.is_guess:
        roles = [_read_only_role(node.node, role.prop, "") if role.name in CONTROLS else role for role in roles]
    return replace(node, kind="" if node.is_guess else node.kind, roles=tuple(roles))


def _singled(node: HomieNode, suggested: Iterable[Role]) -> tuple[Role, ...]:
    """Return the roles; of two properties that would control the same the first one does."""
    taken: set[str] = set()
    roles: list[Role] = []
    for role in suggested:
        is_taken = role.name in CONTROLS and role.name in taken
        roles.append(_read_only_role(node, role.prop, "") if is_taken else role)
        taken.add(role.name)
    return tuple(roles)


def _is_borne_out(kind: str, props: Mapping[str, HomieProperty]) -> bool:
    """Return whether the forms of *props*, by role, bear out the *kind* that words suggested."""
    if kind == "fan":
        speed = props.get("fan_mode")
        return not props.keys().isdisjoint({"on_off", "fan_speed"}) or (speed is not None and _is_speed(speed))
    return not props.keys().isdisjoint(_EVIDENCE[kind])


_EVIDENCE: Mapping[str, frozenset[str]] = {
    "garage-door": frozenset({"position", "movement", "move"}),
    "shutter": frozenset({"position", "tilt", "movement", "move"}),
    "lock": frozenset({"lock", "lock_action"}),
    "thermostat": frozenset({*THERMOSTAT_ROLES, "local_temperature"}),
    "valve": frozenset({"valve"}),
    "light": frozenset({"on_off", "level", "color", "color_temperature"}),
}
"""Of each kind that words may suggest, besides a fan: the roles of which it has at least one."""


_Fit = Callable[[HomieProperty], bool]


def _is_number(prop: HomieProperty) -> bool:
    return prop.is_number


def _is_flag(prop: HomieProperty) -> bool:
    return prop.datatype == "boolean"


def _is_command(prop: HomieProperty) -> bool:
    return prop.datatype == "enum" and prop.is_settable


def _is_choice(prop: HomieProperty) -> bool:
    return prop.datatype == "enum"


_FITS: Mapping[str, _Fit] = {
    **dict.fromkeys(("on_off", "lock", "valve", "battery_low"), _is_flag),
    **dict.fromkeys(("level", "color_temperature", "position", "tilt", "fan_speed", "battery"), _is_number),
    **dict.fromkeys(("heating_setpoint", "cooling_setpoint"), _is_number),
    **dict.fromkeys(("move", "lock_action"), _is_command),
    **dict.fromkeys(("thermostat_mode", "fan_mode"), _is_choice),
    "color": lambda prop: prop.datatype == "color",
    "movement": _is_opening,
    "local_temperature": lambda prop: prop.is_number and not prop.is_settable,
    "press": lambda prop: prop.datatype in {"enum", "string"},
}


def _declared_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
    name = KINDS[kind].roles.get(prop.id, "")
    if name == "fan_mode" and prop.is_number:
        name = "fan_speed"
    if name and _FITS[name](prop):
        return Role(name, prop, is_guess=False)
    if KINDS[kind].condition and prop.datatype == "boolean" and not prop.is_settable:
        first = next(one for one in node.properties if one.datatype == "boolean" and not one.is_settable)
        if first is prop:
            return Role(KINDS[kind].condition, prop, is_guess=False)
    return _read_only_role(node, prop, kind)


def _guessed_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
    tokens = tokens_in(prop.id, prop.name)
    name = _guess_role(node, prop, kind, tokens)
    return Role(name, prop, is_guess=True) if name else _read_only_role(node, prop, kind)


def _read_only_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
    """Return the role of a property that controls nothing by itself."""
    if prop.is_settable:
        return Role("", prop, is_guess=False)
    tokens = tokens_in(prop.id, prop.name)
    around = tokens_in(node.id, node.name, kind)
    if prop.is_number:
        name, is_guess = quantity_of(prop.unit, tokens | around)
        return Role(name, prop, is_guess)
    if prop.datatype == "boolean":
        name = condition_of(tokens, around)
        return Role(name, prop, is_guess=name != "state")
    return Role("value" if prop.is_retained else "press", prop, is_guess=False)
