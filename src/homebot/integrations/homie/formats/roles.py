"""Roles of a node's properties: by its type, and without one by the forms of its properties alone. Pure.

A type is that of the smart-home profile, or the word of one, such as ``light``. Of names and ids only those of the
profile decide, and "lock", so that nothing that may open a door is a setting (decision 40).

Source: hc-smarthome v2.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from homebot.integrations.homie.formats.model import HomieNode, HomieProperty
from homebot.integrations.homie.formats.node_types import KINDS, declared_kind, quantity_of, tokens_in


def _options(prop: HomieProperty) -> frozenset[str]:
    return frozenset(option.casefold() for option in prop.options) if prop.datatype == "enum" else frozenset()


def _is_opening(prop: HomieProperty) -> bool:
    return prop.datatype == "enum" and _options(prop) <= _OPENINGS


def _is_moving(prop: HomieProperty) -> bool:
    options = _options(prop)
    return bool(options & {"open", "up"}) and bool(options & {"close", "closed", "down"})


def _is_white(prop: HomieProperty) -> bool:
    """Return whether its unit and its range are those of a colour temperature."""
    return prop.unit in _WHITES and (prop.unit != "K" or prop.range.most is None or prop.range.most > _MIN_KELVIN)


def _is_share(prop: HomieProperty) -> bool:
    """Return whether its range is that of a percentage or a byte, from 0 or 1."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0, 1.0} and prop.range.most in {None, *_ENDS}


def _is_speed(prop: HomieProperty) -> bool:
    """Return whether its numbers are percent, or steps from 0 or 1."""
    return prop.unit in {"", "%"} and prop.range.least in {None, 0.0, 1.0} and (prop.range.most or 0.0) <= max(_ENDS)


def _is_room_temperature(prop: HomieProperty) -> bool:
    """Return whether 20 °C is in its range, unlike in that of an offset or a hysteresis."""
    unit = prop.unit.strip()
    return (unit in _CELSIUS and prop.range.holds(20.0)) or (unit in _FAHRENHEIT and prop.range.holds(68.0))


def _has_lock_states(prop: HomieProperty) -> bool:
    return {"locked", "unlocked"} <= _options(prop)


def _is_locking(prop: HomieProperty) -> bool:
    return {"lock", "unlock"} <= _options(prop) or (prop.is_settable and _has_lock_states(prop))


def _tells_lock(prop: HomieProperty) -> bool:
    return not prop.is_settable and _has_lock_states(prop)


def _tells_alarm(prop: HomieProperty) -> bool:
    options = _options(prop)
    return "disarmed" in options and any(option.startswith("armed") for option in options)


def _is_valve(prop: HomieProperty) -> bool:
    return prop.is_settable and _flags(prop) == ("closed", "open")


def _is_contact(prop: HomieProperty) -> bool:
    return not prop.is_settable and _flags(prop) == ("closed", "open")


def _flags(prop: HomieProperty) -> tuple[str, ...]:
    return tuple(flag.casefold() for flag in prop.flags)


_THERMAL = frozenset({"heat", "heating", "cool", "cooling", "heat_cool"})
_OPENINGS = frozenset({"open", "closed", "opening", "closing", "stopped", "close", "up", "down", "stop"})
_WHITES = frozenset({"K", "MK⁻¹", "mired", "mireds"})
_CELSIUS = frozenset({"", "°C", "C"})
_FAHRENHEIT = frozenset({"°F", "F"})
_ENDS = frozenset({1.0, 100.0, 254.0, 255.0})
_MIN_KELVIN = 1000.0
_NUMBER = frozenset({"integer", "float"})
_BOOLEAN = frozenset({"boolean"})
_ENUM = frozenset({"enum"})
_COLOR = frozenset({"color"})


class _Form(NamedTuple):
    """A role of the only property of a node that has this form.

    Attributes:
        kinds: Words of the node's type; empty for a node without a known type.
    """

    role: str
    kinds: tuple[str, ...]
    datatypes: frozenset[str]
    fits: Callable[[HomieProperty], bool] = lambda prop: prop.is_settable

    def holds(self, prop: HomieProperty) -> bool:
        return prop.datatype in self.datatypes and self.fits(prop)


def _settable(fits: Callable[[HomieProperty], bool]) -> Callable[[HomieProperty], bool]:
    return lambda prop: prop.is_settable and fits(prop)


_LIGHTS = ("light", "level", "dimmer", "color", "colorlight")
_COVERS = ("shutter", "garage-door")

_FORMS: tuple[_Form, ...] = (
    _Form("on_off", ("switch", "fan", *_LIGHTS), _BOOLEAN),
    _Form("color", ("", *_LIGHTS), _COLOR),
    _Form("color_temperature", ("", *_LIGHTS), _NUMBER, _settable(_is_white)),
    _Form("level", _LIGHTS, _NUMBER, _settable(_is_share)),
    _Form("position", _COVERS, _NUMBER, _settable(_is_share)),
    _Form("move", _COVERS, _ENUM, _settable(_is_moving)),
    _Form("movement", _COVERS, _ENUM, lambda prop: not prop.is_settable and _is_opening(prop)),
    _Form("lock", ("lock",), _BOOLEAN),
    _Form("lock", ("lock",), _ENUM, _tells_lock),
    _Form("lock_action", ("", "lock"), _ENUM, _settable(_is_locking)),
    _Form("alarm", ("",), _ENUM, lambda prop: not prop.is_settable and _tells_alarm(prop)),
    _Form("arm", ("",), _ENUM, _settable(_tells_alarm)),
    _Form("valve", ("valve",), _BOOLEAN),
    _Form("valve", ("",), _BOOLEAN, _is_valve),
    _Form("on_off", ("",), _BOOLEAN),
    _Form("contact", ("",), _BOOLEAN, _is_contact),
    _Form("heating_setpoint", ("thermostat",), _NUMBER, _settable(_is_room_temperature)),
    _Form("thermostat_mode", ("thermostat",), _ENUM, _settable(lambda prop: bool(_options(prop) & _THERMAL))),
    _Form("fan_speed", ("fan",), _NUMBER, _settable(_is_speed)),
    _Form("fan_mode", ("fan",), _ENUM),
)
"""Roles by form. Without a type these are colours, switches, and what is to ask: locks, alarms and valves.

Source of the flags of breakers, valves and contacts: see ``node_reader``.
"""


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


@dataclass(frozen=True, slots=True)
class NodeRoles:
    """The roles of a node's properties, and its kind, which is empty if unknown; a guess if forms decide."""

    node: HomieNode
    kind: str
    is_guess: bool
    roles: tuple[Role, ...]

    def prop(self, name: str) -> HomieProperty | None:
        """Return the first property with the role *name*."""
        return next((role.prop for role in self.roles if role.name == name), None)


def find_roles(node: HomieNode) -> NodeRoles:
    """Return the roles of the properties of *node*."""
    if declared := declared_kind(node.type):
        roles = _singled(node, (_declared_role(node, prop, declared) for prop in node.properties))
        return NodeRoles(node, declared, is_guess=False, roles=roles)
    kind = node.type.strip().casefold()
    if kind not in KINDS:
        settable = [prop.id for prop in node.properties if prop.is_settable]
        words = tokens_in(node.type, node.id, node.name, *settable)
        # a setting of that name would not ask
        kind = "lock" if settable and "lock" in words and words.isdisjoint(_CHARGERS) else ""
    roles = _roles_by_form(node, kind)
    names = {role.name for role in roles}
    if not kind:
        kind = "lock" if "lock_action" in names else "valve" if "valve" in names else ""
    return NodeRoles(node, kind, is_guess=True, roles=roles)


_CHARGERS = frozenset({"charger", "ev", "evse"})
_OTHER_LOCKS = frozenset({"auto", "child", "keypad", "keys", "panel"})
"""Words of what locks no door, or is no lock."""


def _roles_by_form(node: HomieNode, kind: str) -> tuple[Role, ...]:
    own = node.properties
    if kind == "lock":
        own = tuple(prop for prop in own if tokens_in(prop.id, prop.name).isdisjoint(_OTHER_LOCKS))
    names: dict[str, str] = {}
    if kind:
        declared = {KINDS[kind].condition, *KINDS[kind].roles.values()} - {""}
        declared_roles = (_declared_role(node, prop, kind) for prop in own)
        names = {role.prop.id: role.name for role in declared_roles if role.name in declared}
    for form in (form for form in _FORMS if kind in form.kinds):
        fitting = [prop for prop in own if form.holds(prop)]
        if len(fitting) == 1 and form.role not in names.values():
            names.setdefault(fitting[0].id, form.role)
    roles = (
        Role(names[prop.id], prop) if prop.id in names else _read_only_role(node, prop) for prop in node.properties
    )
    return _singled(node, roles)


def as_settings(node: NodeRoles, without: tuple[HomieProperty, ...]) -> NodeRoles:
    """Return *node* without guessed controls, and without the given properties."""
    roles = [role for role in node.roles if role.prop not in without]
    if node.is_guess:
        roles = [_read_only_role(node.node, role.prop) if role.name in CONTROLS else role for role in roles]
    return replace(node, kind="" if node.is_guess else node.kind, roles=tuple(roles))


def _singled(node: HomieNode, suggested: Iterable[Role]) -> tuple[Role, ...]:
    """Return the roles; of several properties with one control the first has it."""
    used: set[str] = set()
    roles: list[Role] = []
    for role in suggested:
        is_used = role.name in CONTROLS and role.name in used
        roles.append(_read_only_role(node, role.prop) if is_used else role)
        used.add(role.name)
    return tuple(roles)


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
        return Role(name, prop)
    flags = (flag for flag in node.properties if flag.datatype == "boolean" and not flag.is_settable)
    if KINDS[kind].condition and next(flags, None) is prop:
        return Role(KINDS[kind].condition, prop)
    return _read_only_role(node, prop)


def _read_only_role(node: HomieNode, prop: HomieProperty) -> Role:
    if prop.is_settable:
        return Role("", prop)
    if prop.is_number:
        return Role(quantity_of(prop.unit, tokens_in(prop.id, prop.name, node.id)), prop)
    if prop.datatype == "boolean":
        return Role("state", prop)
    return Role("value" if prop.is_retained else "press", prop)
