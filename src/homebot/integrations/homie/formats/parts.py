"""Parts of a Homie device. Pure.

The controls of a node are one part, each reported value is another, and each other settable value is a setting. Switch,
brightness and colour of a lamp are one part, also from several nodes. In a robot that cleans, nodes without a declared
kind are settings: the power of its fan makes it no fan.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.conventions.units import sensor_type
from homebot.devices.always_ask import BREAKER
from homebot.devices.part import Category, payload_digest
from homebot.integrations.homie.formats.controls import (
    LIGHT_ROLES,
    add_alarm,
    add_cover,
    add_fan,
    add_lift,
    add_light,
    add_lock,
    build_vacuum,
    find_vacuum,
)
from homebot.integrations.homie.formats.model import STATES, HomieDevice, HomieNode, HomieProperty
from homebot.integrations.homie.formats.properties import add_properties, add_property, node_part
from homebot.integrations.homie.formats.roles import (
    CONTROLS,
    KINDS,
    THERMOSTAT_ROLES,
    NodeRoles,
    Role,
    as_settings,
    declared_class,
    find_roles,
    tokens_in,
)


def build_parts(device: HomieDevice) -> tuple[DescribedPart, ...]:
    """Return the parts of *device*, the main one first."""
    nodes = tuple(map(find_roles, device.nodes))
    controls: list[BytesPart] = []
    vacuum = find_vacuum(nodes)
    if vacuum is not None:
        controls.append(build_vacuum(vacuum))
        nodes = tuple(as_settings(node, vacuum.props) for node in nodes)
    others: list[BytesPart] = []
    lamp = _lamp(device, nodes)
    if lamp:
        props = {role: prop for role in LIGHT_ROLES for node in lamp if (prop := node.prop(role)) is not None}
        part = node_part(lamp[0].node, "light", guessed=any(node.is_guess for node in lamp))
        add_light(part, props)
        controls.append(part)
    for node in nodes:
        controls.extend(_alarms(node))
        if node not in lamp:
            controls.extend(_controls(device, node))
        others.extend((*_meters(node, is_of_circuit=device.type == _CIRCUIT), *_singles(node)))
    settable = [prop for node in device.nodes for prop in node.properties if prop.is_settable]
    formats = [(prop.topic, prop.datatype, prop.unit, prop.range, prop.options) for prop in settable]
    digest = payload_digest(formats) if formats else ""
    return tuple(part.build(digest=digest) for part in (*controls, *others))


def build_alert(device: HomieDevice) -> DescribedPart:
    """Return the part that tells that *device*, of version 3 or 4, needs a person: its state is ``alert``."""
    part = BytesPart("$state", sensor_type("problem"), name="alert", category="diagnostic")
    part.read_from(f"{device.topic}/$state", _read_alert)
    part.add_capability("problem")
    return part.build()


def _read_alert(payload: bytes) -> Readings:
    """Read the state; of a device that is away, the last problem stays."""
    state = payload.decode(errors="replace")
    return {"problem": state == "alert"} if STATES.get(state) else NO_READINGS


_OUTLETS = frozenset({"outlet", "plug", "socket"})
_ADDERS: Mapping[str, Callable[[BytesPart, Mapping[str, HomieProperty]], None]] = {
    "window_covering": add_cover,
    "closure": add_cover,
    "door_lock": add_lock,
    "fan": add_fan,
    "light": add_light,
    "x_lift": add_lift,
}
"""Adders of controls that are more than their single properties."""

_SINGLE = (
    "on_off",
    "valve",
    "heating_setpoint",
    "cooling_setpoint",
    "local_temperature",
    "thermostat_mode",
    "fan_mode",
)


def _lamp(device: HomieDevice, nodes: tuple[NodeRoles, ...]) -> tuple[NodeRoles, ...]:
    """Return the nodes of the only lamp; none for no lamp or several."""
    lamp = tuple(filter(_may_be_of_a_lamp, nodes))
    roles = [role for node in lamp for role in _light_roles(node)]
    if len(set(roles)) != len(roles):
        return ()
    is_guessed = any(node.kind == "light" and node.is_guess for node in lamp)
    is_lamp = is_guessed or declared_class(device.type) == "light" or set(roles) - {"on_off"}
    return lamp if is_lamp else ()


def _light_roles(node: NodeRoles) -> frozenset[str]:
    return frozenset(role.name for role in node.roles) & set(LIGHT_ROLES)


def _may_be_of_a_lamp(node: NodeRoles) -> bool:
    """Return whether it has a role of a lamp, and no kind of another: the switch of a pump is no part of a lamp."""
    if not _light_roles(node):
        return False
    return not node.kind or node.kind == "switch" or node.kind in _LIGHTS


_LIGHTS = frozenset(name for name, kind in KINDS.items() if kind.service_type == "light")


def _controls(device: HomieDevice, node: NodeRoles) -> Iterator[BytesPart]:
    props = {role.name: role.prop for role in node.roles if role.name in CONTROLS}
    kind = KINDS[node.kind].service_type if node.kind else ""
    possible = (kind, "light", "window_covering", "switch")
    guess = next((candidate for candidate in possible if props.keys() & _NEEDED.get(candidate, frozenset())), "")
    service_type = "plug" if guess == "switch" and _OUTLETS & tokens_in(node.node.type, device.type) else guess
    if not service_type:
        return
    tag = KINDS[node.kind].tag if node.kind else ""
    if service_type == "switch" and props["on_off"].flags[0].casefold() == "open":
        tag = BREAKER
    part = node_part(node.node, service_type, tag=tag, guessed=node.is_guess)
    if service_type in _ADDERS:
        _ADDERS[service_type](part, props)
    else:
        add_properties(part, props, *_SINGLE)
    if not part.is_empty:
        yield part


_NEEDED: Mapping[str, frozenset[str]] = {
    "light": frozenset({"level", "color", "color_temperature"}),
    "window_covering": frozenset({"position", "tilt", "movement", "move"}),
    "closure": frozenset({"position", "movement", "move"}),
    "door_lock": frozenset({"lock", "lock_action"}),
    "x_lift": frozenset({"floor"}),
    "water_valve": frozenset({"valve"}),
    "thermostat": THERMOSTAT_ROLES,
    "fan": frozenset({"fan_mode", "fan_speed", "on_off"}),
    "switch": frozenset({"on_off"}),
}


def _alarms(node: NodeRoles) -> Iterator[BytesPart]:
    """Describe the alarm of a node, which may have other controls."""
    props = {role.name: role.prop for role in node.roles if role.name in _OF_ALARM}
    if props:
        part = node_part(node.node, "x_alarm_panel", suffix="$alarm", guessed=True)
        add_alarm(part, props)
        yield part


_OF_ALARM = frozenset({"alarm", "arm"})
_ELECTRICAL = frozenset({"power", "energy", "energy_returned", "voltage", "current", "frequency"})
_CIRCUIT = "energy.ebus.device.circuit"
"""Device type of a circuit of a panel, which measures it the other way: as flowing into the panel. Source: eBus."""

_FROM_CIRCUIT = {"energy": "energy_returned", "energy_returned": "energy"}
_DIAGNOSTIC = frozenset({"battery", "battery_low", "signal_strength"})
_ABOUT = frozenset({"info", "maintenance"})
"""Words of nodes about the device itself, as of eBus and hc-smarthome."""

_SETTINGS: Mapping[str, str] = {"boolean": "state", "integer": "number", "float": "number", "enum": "option"}


def _meters(node: NodeRoles, *, is_of_circuit: bool) -> Iterator[BytesPart]:
    roles = _metered(node)
    if not roles:
        return
    part = node_part(node.node, "electrical_meter", suffix="$meter")
    for role in reversed(roles.values()):
        name, prop = role.name, role.prop
        if is_of_circuit:
            name = _FROM_CIRCUIT.get(name, name)
            prop = replace(prop, sign=-1.0) if name == "power" else prop
        add_property(part, name, prop)
    yield part


def _metered(node: NodeRoles) -> dict[str, Role]:
    """Return the first role of each electrical quantity, the last ones first."""
    return {role.name: role for role in reversed(node.roles) if role.name in _ELECTRICAL}


def _singles(node: NodeRoles) -> Iterator[BytesPart]:
    """Describe the other properties of a node: sensors and settings, each a part."""
    has_thermostat = any(role.name in THERMOSTAT_ROLES for role in node.roles)
    metered = _metered(node).values()
    for role in node.roles:
        if role in metered:
            continue
        if role.name == "local_temperature":
            if not has_thermostat:
                yield _sensor(node.node, Role("temperature", role.prop))
        elif role.name and role.name not in CONTROLS:
            yield _sensor(node.node, role)
        elif not role.name:
            prop = role.prop
            if prop.datatype == "enum" and not prop.is_retained and set(prop.options) <= _RELATIVE:
                continue  # homebot's commands are absolute
            setting = node_part(node.node, "x_setting", suffix=prop.id, name=prop.name, category="config")
            add_property(setting, _SETTINGS.get(prop.datatype, "text"), prop)
            yield setting


_RELATIVE = frozenset({"toggle", "brighter", "darker", "step-up", "step-down", "trigger"})


def _sensor(node: HomieNode, role: Role) -> BytesPart:
    is_about = not _ABOUT.isdisjoint(tokens_in(node.id, node.type))
    category: Category = "diagnostic" if is_about or role.name in _DIAGNOSTIC else ""
    service_type = sensor_type(role.name)
    part = node_part(node, service_type, suffix=role.prop.id, name=role.prop.name, category=category)
    add_property(part, role.name, role.prop)
    return part
