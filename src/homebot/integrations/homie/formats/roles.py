"""Types of nodes, and the roles of their properties: by the type, and without one by the forms alone. Pure.

A type is that of the smart-home profile, or the word of one, such as ``light``. Of names and ids only those of the
profile decide, and "lock", so that nothing that may open a door is a setting (decision 40).

Source: hc-smarthome v2 and v1 (homie-homecontrol/hc-homie5-smarthome); homie5-device-profiles, draft; Homie convention
5, Units.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from homebot.conventions.units import measured_in
from homebot.integrations.homie.formats.model import HomieNode, HomieProperty


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of node.

    Attributes:
        service_type: The service type of its controls; empty if it has none.
        condition: The capability of its first reported boolean, with any id.
    """

    service_type: str = ""
    roles: Mapping[str, str] = field(default_factory=dict)
    condition: str = ""
    tag: str = ""


_SWITCH = {"state": "on_off"}
_LEVEL = {"value": "level", "brightness": "level"}
_COLOR_ROLES = {"color": "color", "color-temperature": "color_temperature"}

KINDS: Mapping[str, Kind] = {
    "switch": Kind("switch", _SWITCH),
    "level": Kind("light", _LEVEL),
    "dimmer": Kind("light", _LEVEL),
    "color": Kind("light", _COLOR_ROLES),
    "colorlight": Kind("light", _COLOR_ROLES),
    "light": Kind("light", {**_SWITCH, "brightness": "level", **_COLOR_ROLES}),
    "shutter": Kind("window_covering", {"position": "position", "tilt": "tilt", "action": "move"}, tag="shutter"),
    "garage-door": Kind("closure", {"state": "movement", "action": "move"}, tag="garage"),
    "lock": Kind("door_lock", {"state": "lock", "action": "lock_action"}),
    "lift": Kind("x_lift", {"floor": "floor", "door": "movement", "session": "session"}),
    "valve": Kind("water_valve", {"state": "valve"}),
    "thermostat": Kind(
        "thermostat",
        {"set-temperature": "heating_setpoint", "mode": "thermostat_mode", "temperature": "local_temperature"},
    ),
    "fan": Kind("fan", {"speed": "fan_mode", "state": "on_off"}),
    "motion": Kind(condition="occupancy"),
    "contact": Kind(condition="contact"),
    "water": Kind(condition="water_leak"),
    "smoke": Kind(condition="smoke"),
    "co": Kind(condition="carbon_monoxide_alarm"),
    "vibration": Kind(condition="vibration"),
    "tilt": Kind(condition="state"),
    "battery": Kind(roles={"battery-level": "battery", "low-battery": "battery_low"}),
    "maintenance": Kind(roles={"battery-level": "battery", "low-battery": "battery_low"}),
    "button": Kind(roles={"action": "press"}),
    "controls": Kind(  # Homie4 0.4 (PyPI), Device_Thermostat
        "thermostat",
        {
            "heatsetpoint": "heating_setpoint",
            "coolsetpoint": "cooling_setpoint",
            "systemmode": "thermostat_mode",
            "fanmode": "fan_mode",
        },
    ),
    **{name: Kind() for name in ("climate", "weather", "illuminance", "powermeter", "air-quality", "numeric", "scene")},
}
"""Kinds by the name at the end of a node's type."""

_DECLARED = re.compile(
    r"(?:hc-smarthome/v[0-9]+/cap/|(?:homie-homecontrol|hc-smarthome|homie-capability-profile)/v[0-9]+/type=)"
    r"([a-z0-9-]{1,40})"
)
_CLASS = re.compile(r"(?:hc-smarthome/v[0-9]+/dc/|homie-device-profile/v[0-9]+/type=)([a-z0-9-]{1,40})")

_TOKEN = re.compile(r"[a-z]+[0-9]*")
_MAX_CHARACTERS = 200


def declared_kind(node_type: str) -> str:
    """Return the name of the declared kind of *node_type*; empty if it is unknown."""
    match = _DECLARED.fullmatch(node_type)
    return match[1] if match is not None and match[1] in KINDS else ""


def declared_class(device_type: str) -> str:
    """Return the declared class of a device, such as ``light`` or ``outlet``; empty for none."""
    match = _CLASS.fullmatch(device_type)
    return match[1] if match is not None else ""


def tokens_in(*texts: str) -> frozenset[str]:
    """Return the words of *texts* in small letters."""
    return frozenset(token for text in texts for token in _TOKEN.findall(text[:_MAX_CHARACTERS].casefold()))


_RATINGS = frozenset({"advertised", "limit", "maximum", "nameplate", "nominal", "rated", "rating", "soe"})
"""Words for purposes, limits and contents, which are not measured: a breaker of 200 A."""

_RETURNED = frozenset({"export", "exported", "returned"})


_SHARES = ("battery", "humidity")
"""Quantities in percent by their words: of robots by Valetudo, and of the node ``status`` of Homie4 0.4 (PyPI)."""


def quantity_of(unit: str, tokens: frozenset[str]) -> str:
    """Return the capability of a number by its unit.

    Args:
        tokens: The words of its property and its node: a few of products that people own decide too.
    """
    unit = unit.strip()
    if not tokens.isdisjoint(_RATINGS):
        return "measurement"
    if unit == "%":
        return next((name for name in _SHARES if any(token.startswith(name) for token in tokens)), "measurement")
    if unit == "dBm":
        return "signal_strength"
    capability = measured_in(unit) or "measurement"
    return "energy_returned" if capability == "energy" and tokens & _RETURNED else capability


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
        "floor",
        "session",
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
        roles = _single_out(node, (_declared_role(node, prop, declared) for prop in node.properties))
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
    return _single_out(node, roles)


def as_settings(node: NodeRoles, without: tuple[HomieProperty, ...]) -> NodeRoles:
    """Return *node* without guessed controls, and without the given properties."""
    roles = [role for role in node.roles if role.prop not in without]
    if node.is_guess:
        roles = [_read_only_role(node.node, role.prop) if role.name in CONTROLS else role for role in roles]
    return replace(node, kind="" if node.is_guess else node.kind, roles=tuple(roles))


def _single_out(node: HomieNode, suggested: Iterable[Role]) -> tuple[Role, ...]:
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
    **dict.fromkeys(("move", "lock_action", "thermostat_mode", "fan_mode", "movement", "floor"), _ENUM),
    "session": frozenset({"string"}),
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
