"""Roles of a node's properties: declared by its type, or guessed from names and formats. Pure.

Source: hc-smarthome v2; the words and forms that Homie devices commonly use.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from homebot.integrations.homie.formats.model import HomieNode, HomieProperty
from homebot.integrations.homie.formats.node_types import (
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


def _options(prop: HomieProperty) -> frozenset[str]:
    return frozenset(option.casefold() for option in prop.options) if prop.datatype == "enum" else frozenset()


def _is_opening(prop: HomieProperty) -> bool:
    return prop.datatype == "enum" and _options(prop) <= _OPENINGS


def _is_moving(prop: HomieProperty) -> bool:
    options = _options(prop)
    return bool(options & {"open", "up"}) and bool(options & {"close", "closed", "down"})


def _is_speed(prop: HomieProperty) -> bool:
    """Return whether it is an enum of speeds, with one for standing still."""
    return not _STANDING.isdisjoint(_options(prop)) and not _is_moving(prop)


def _is_white(prop: HomieProperty) -> bool:
    """Return whether its unit and its range are those of a colour temperature."""
    return prop.unit in _WHITES and (prop.unit != "K" or prop.range.most is None or prop.range.most > _LEAST_KELVIN)


def _is_fraction(prop: HomieProperty) -> bool:
    """Return whether its range is that of a percentage or a byte, from 0 or 1."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0, 1.0} and prop.range.most in {None, *_ENDS}


def _is_level(prop: HomieProperty) -> bool:
    return _is_fraction(prop) and prop.range.most is not None


def _is_speed_range(prop: HomieProperty) -> bool:
    """Return whether its numbers are percent, or steps from 0 or 1."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0, 1.0} and (prop.range.most or 0.0) <= max(_ENDS)


def _is_room_temperature(prop: HomieProperty) -> bool:
    """Return whether 20 °C is in its range, unlike in that of an offset or a hysteresis."""
    unit = prop.unit.strip()
    return (unit in _CELSIUS and prop.range.holds(20.0)) or (unit in _FAHRENHEIT and prop.range.holds(68.0))


def _is_cooling(prop: HomieProperty) -> bool:
    return _is_room_temperature(prop) and any(one.startswith("cool") for one in tokens_in(prop.id, prop.name))


def _has_lock_states(prop: HomieProperty) -> bool:
    return {"locked", "unlocked"} <= _options(prop)


def _is_locking(prop: HomieProperty) -> bool:
    return {"lock", "unlock"} <= _options(prop) or _has_lock_states(prop)


def _is_arming(prop: HomieProperty) -> bool:
    options = _options(prop)
    return "disarmed" in options and any(one.startswith("armed") for one in options)


def _is_climate_mode(prop: HomieProperty) -> bool:
    return prop.id in _MODES and bool(_options(prop) & _THERMAL)


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
_NUMBER = frozenset({"integer", "float"})
_BOOLEAN = frozenset({"boolean"})
_ENUM = frozenset({"enum"})
_COLOR = frozenset({"color"})
_COVERS = ("shutter", "garage-door")
_SWITCHED = tuple(kind for kind in ("", *KINDS) if kind not in {"lock", "valve"})


class _Guess(NamedTuple):
    """A role of a property, guessed from its node's kind, its datatype, its words and its form.

    Attributes:
        kinds: Kinds of nodes; None for every kind.
        words: One of them is required; None for any words.
        is_main: Whether the property with the id of its node needs no words.
    """

    role: str
    kinds: tuple[str, ...] | None
    datatypes: frozenset[str]
    words: frozenset[str] | None = None
    fits: Callable[[HomieProperty], bool] = lambda _: True
    is_main: bool = False

    def matches(self, prop: HomieProperty, kind: str, tokens: frozenset[str], *, is_main: bool) -> bool:
        """Return whether *prop* has this role; *is_main* means that it has the id of its node."""
        if (self.kinds is not None and kind not in self.kinds) or prop.datatype not in self.datatypes:
            return False
        is_named = self.words is None or bool(tokens & self.words) or (self.is_main and is_main)
        return is_named and self.fits(prop)


_SETTABLE: tuple[_Guess, ...] = (
    _Guess("color", ("light", ""), _COLOR),
    _Guess("lock", ("lock",), _BOOLEAN, _LOCKING, is_main=True),
    _Guess("valve", ("valve",), _BOOLEAN, _FLOWING, is_main=True),
    _Guess("on_off", _SWITCHED, _BOOLEAN, _SWITCHING, is_main=True),
    _Guess("cooling_setpoint", ("thermostat",), _NUMBER, _SETPOINTS, _is_cooling),
    _Guess("heating_setpoint", ("thermostat",), _NUMBER, _SETPOINTS, _is_room_temperature),
    _Guess("tilt", (*_COVERS, "position"), _NUMBER, _TILTS),
    _Guess("position", (*_COVERS, "position"), _NUMBER, _POSITIONS, _is_fraction, is_main=True),
    _Guess("fan_speed", ("fan",), _NUMBER, _SPEEDS, _is_speed_range, is_main=True),
    _Guess("color_temperature", ("light", "level", ""), _NUMBER, None, _is_white),
    _Guess("level", ("light", "level"), _NUMBER, _LEVELS, _is_level),
    _Guess("level", ("",), _NUMBER, _BRIGHT, _is_level),
    _Guess("fan_mode", ("fan",), _ENUM, _SPEEDS, is_main=True),
    _Guess("fan_mode", ("thermostat",), _ENUM, frozenset({"fan", "fanmode"})),
    _Guess("thermostat_mode", ("thermostat",), _ENUM, None, _is_climate_mode),
    _Guess("move", _COVERS, _ENUM, None, _is_moving),
    _Guess("lock_action", ("lock",), _ENUM, None, _is_locking),
)
_REPORTED: tuple[_Guess, ...] = (
    _Guess("local_temperature", ("thermostat",), _NUMBER, frozenset({"temperature"})),
    _Guess("movement", _COVERS, _ENUM, None, lambda prop: _is_opening(prop) and _is_moving(prop)),
    _Guess("lock", ("lock",), _BOOLEAN, _LOCKING, is_main=True),
    _Guess("lock", ("lock",), _ENUM, None, _has_lock_states),
    _Guess("press", None, _BOOLEAN, frozenset({"button", "doorbell"})),
)
_REPORTED_BESIDE = tuple(guess for guess in _REPORTED if guess.role in {"movement", "press"})
"""Roles of properties that do not serve the purpose of their node."""


def _guess(node: HomieNode, prop: HomieProperty, kind: str) -> str:
    if not kind and _is_arming(prop):
        return "arm" if prop.is_settable else "alarm"
    tokens = tokens_in(prop.id, prop.name)
    guesses = _SETTABLE
    if not prop.is_settable:
        guesses = _REPORTED_BESIDE if is_beside(tokens) else _REPORTED
    elif is_beside(tokens - _OF_VALVES if kind == "valve" else tokens) or is_setting(tokens_in(node.id, node.name)):
        return ""
    if prop.is_number and not kind:
        kind = _kind_of_number(node, tokens)
    is_main = prop.id == node.id
    return next((guess.role for guess in guesses if guess.matches(prop, kind, tokens, is_main=is_main)), "")


def _kind_of_number(node: HomieNode, tokens: frozenset[str]) -> str:
    if "position" in tokens:
        return "position"
    return "level" if tokens_in(node.id, node.type) & _LEVELS else ""


CONTROLS = frozenset(
    {"on_off", "level", "color", "color_temperature", "position", "tilt", "movement", "move", "lock", "lock_action"}
    | {
        "alarm",
        "arm",
        "valve",
        "heating_setpoint",
        "cooling_setpoint",
        "thermostat_mode",
        "fan_mode",
        "fan_speed",
        "local_temperature",
    }
)
"""Roles of controls; every other role is a capability that is only reported."""

THERMOSTAT_ROLES = frozenset({"heating_setpoint", "cooling_setpoint", "thermostat_mode"})
"""Roles of a thermostat, which has at least one of them."""


@dataclass(frozen=True, slots=True)
class Role:
    """The role of a property.

    Attributes:
        name: One of :data:`CONTROLS`, or the reported capability; empty for a setting.
    """

    name: str
    prop: HomieProperty
    is_guess: bool


@dataclass(frozen=True, slots=True)
class NodeRoles:
    """The roles of a node's properties, and its kind, which is empty if unknown and perhaps a guess."""

    node: HomieNode
    kind: str
    is_guess: bool
    roles: tuple[Role, ...]

    def prop(self, name: str) -> HomieProperty | None:
        """Return the first property with the role *name*."""
        return next((role.prop for role in self.roles if role.name == name), None)


def find_roles(node: HomieNode, around: frozenset[str]) -> NodeRoles:
    """Return the roles of the properties of *node*; *around* are the words of its device."""
    declared = declared_kind(node.type)
    if declared:
        roles = _singled(node, (_declared_role(node, prop, declared) for prop in node.properties))
        return NodeRoles(node, declared, is_guess=False, roles=roles)
    kinds = guessed_kinds(node, around)
    for kind in kinds:
        roles = _guessed_roles(node, kind)
        if _is_proven(kind, {role.name: role.prop for role in roles}):
            return NodeRoles(node, kind, is_guess=True, roles=roles)
    roles = _guessed_roles(node, "")
    if kinds:
        roles = tuple(_read_only_role(node, role.prop, "") if role.name in _SHARES else role for role in roles)
    return NodeRoles(node, "", is_guess=True, roles=roles)


_SHARES = frozenset({"level", "position", "tilt"})
"""Roles that a number alone does not prove if words suggest another kind: the position of a valve."""


def as_settings(node: NodeRoles, without: tuple[HomieProperty, ...]) -> NodeRoles:
    """Return *node* without guessed controls, and without the given properties."""
    roles = [role for role in node.roles if role.prop not in without]
    if node.is_guess:
        roles = [_read_only_role(node.node, role.prop, "") if role.name in CONTROLS else role for role in roles]
    return replace(node, kind="" if node.is_guess else node.kind, roles=tuple(roles))


def _singled(node: HomieNode, suggested: Iterable[Role]) -> tuple[Role, ...]:
    """Return the roles; of several properties with one control the first has it."""
    used: set[str] = set()
    roles: list[Role] = []
    for role in suggested:
        is_used = role.name in CONTROLS and role.name in used
        roles.append(_read_only_role(node, role.prop, "") if is_used else role)
        used.add(role.name)
    return tuple(roles)


def _is_proven(kind: str, props: Mapping[str, HomieProperty]) -> bool:
    """Return whether the forms of *props*, by role, prove the *kind* that words suggested."""
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
"""By kind, except fans: the roles that prove it."""

_DATATYPES: Mapping[str, frozenset[str]] = {
    **dict.fromkeys(("on_off", "lock", "valve", "battery_low"), _BOOLEAN),
    **dict.fromkeys(("level", "color_temperature", "position", "tilt", "fan_speed", "battery"), _NUMBER),
    **dict.fromkeys(("heating_setpoint", "cooling_setpoint", "local_temperature"), _NUMBER),
    **dict.fromkeys(("move", "lock_action", "thermostat_mode", "fan_mode", "movement"), _ENUM),
    "color": _COLOR,
    "press": frozenset({"enum", "string"}),
}
"""Datatypes of each declared role."""


def _fits(role: str, prop: HomieProperty) -> bool:
    if prop.datatype not in _DATATYPES[role] or (role == "movement" and not _is_opening(prop)):
        return False
    return prop.is_settable if role in {"move", "lock_action"} else role != "local_temperature" or not prop.is_settable


def _declared_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
    name = KINDS[kind].roles.get(prop.id, "")
    if name == "fan_mode" and prop.is_number:
        name = "fan_speed"
    if name and _fits(name, prop):
        return Role(name, prop, is_guess=False)
    flags = (flag for flag in node.properties if flag.datatype == "boolean" and not flag.is_settable)
    if KINDS[kind].condition and next(flags, None) is prop:
        return Role(KINDS[kind].condition, prop, is_guess=False)
    return _read_only_role(node, prop, kind)


def _guessed_roles(node: HomieNode, kind: str) -> tuple[Role, ...]:
    names = ((_guess(node, prop, kind), prop) for prop in node.properties)
    roles = (Role(name, prop, is_guess=True) if name else _read_only_role(node, prop, kind) for name, prop in names)
    return _singled(node, roles)


def _read_only_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
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
