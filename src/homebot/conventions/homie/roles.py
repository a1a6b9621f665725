"""Roles of a node's properties: as its type declares, or as their form suggests. Pure.

Source: hc-smarthome v2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

from homebot.conventions.homie.heuristics import guess_role, is_opening, is_speed
from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.node_types import (
    KINDS,
    condition_of,
    declared_kind,
    guessed_kinds,
    quantity_of,
    tokens_in,
)

__all__ = ["CONTROLS", "THERMOSTAT_ROLES", "NodeRoles", "Role", "as_settings", "find_roles"]

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
        return not props.keys().isdisjoint({"on_off", "fan_speed"}) or (speed is not None and is_speed(speed))
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


def _is_order(prop: HomieProperty) -> bool:
    return prop.datatype == "enum" and prop.is_settable


def _is_choice(prop: HomieProperty) -> bool:
    return prop.datatype == "enum"


_FITS: Mapping[str, _Fit] = {
    "on_off": _is_flag,
    "level": _is_number,
    "color": lambda prop: prop.datatype == "color",
    "color_temperature": _is_number,
    "position": _is_number,
    "tilt": _is_number,
    "movement": is_opening,
    "move": _is_order,
    "lock": _is_flag,
    "lock_action": _is_order,
    "valve": _is_flag,
    "heating_setpoint": _is_number,
    "cooling_setpoint": _is_number,
    "local_temperature": lambda prop: prop.is_number and not prop.is_settable,
    "thermostat_mode": _is_choice,
    "fan_mode": _is_choice,
    "fan_speed": _is_number,
    "battery": _is_number,
    "battery_low": _is_flag,
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
    name = guess_role(node, prop, kind, tokens)
    return Role(name, prop, is_guess=True) if name else _read_only_role(node, prop, kind)


def _read_only_role(node: HomieNode, prop: HomieProperty, kind: str) -> Role:
    """The role of a property that controls nothing by itself."""
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
