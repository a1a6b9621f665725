"""Parts of a Homie device, and its description. Pure.

The controls of a node are one part, each reported value is another, and each other settable value is a setting. Switch,
brightness and colour of a lamp are one part, also from several nodes. In a robot that cleans, nodes without a declared
kind are settings: the power of its fan makes it no fan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.conventions.homie.controls import (
    add_cover,
    add_fan,
    add_lock,
    add_thermostat,
    add_valve,
    build_vacuum,
    find_vacuum,
)
from homebot.conventions.homie.lights import LIGHT_ROLES, add_light
from homebot.conventions.homie.model import HomieDevice, HomieProperty, availability_of
from homebot.conventions.homie.node_types import KINDS, declared_class, tokens_in
from homebot.conventions.homie.property_codecs import add_flag
from homebot.conventions.homie.roles import CONTROLS, THERMOSTAT_ROLES, NodeRoles, as_settings, find_roles
from homebot.conventions.homie.simple_parts import build_meters, build_singles, node_part
from homebot.conventions.part_builder import BytesPart
from homebot.devices.identity import identifiers

__all__ = ["build_parts", "describe"]


def build_parts(device: HomieDevice) -> tuple[DescribedPart, ...]:
    """Return the parts of *device*, the main one first."""
    around = tokens_in(device.type, device.id, device.name)
    nodes = tuple(find_roles(node, around) for node in device.nodes)
    controls: list[BytesPart] = []
    vacuum = find_vacuum(nodes)
    if vacuum is not None:
        controls.append(build_vacuum(vacuum))
        nodes = tuple(as_settings(node, vacuum.props) for node in nodes)
    others: list[BytesPart] = []
    lamp = _lamp(device, nodes)
    if lamp:
        controls.append(_light(lamp))
    for node in nodes:
        if node not in lamp:
            controls.extend(_controls(device, node))
        others.extend(build_meters(node))
        others.extend(build_singles(node))
    return tuple(part.build() for part in (*controls, *others))


_OUTLETS = frozenset({"outlet", "plug", "socket"})
_Add = Callable[[BytesPart, Mapping[str, HomieProperty]], None]
_ADDERS: Mapping[str, _Add] = {
    "window_covering": add_cover,
    "closure": add_cover,
    "door_lock": add_lock,
    "water_valve": add_valve,
    "thermostat": add_thermostat,
    "fan": add_fan,
    "light": add_light,
    "switch": lambda part, props: add_flag(part, props["on_off"]),
    "plug": lambda part, props: add_flag(part, props["on_off"]),
}


def _lamp(device: HomieDevice, nodes: tuple[NodeRoles, ...]) -> tuple[NodeRoles, ...]:
    """Return the nodes of the only lamp; none for no lamp or several."""
    lamp = tuple(node for node in nodes if _light_roles(node) and _may_be_of_a_lamp(node))
    roles = [role for node in lamp for role in _light_roles(node)]
    if len(set(roles)) != len(roles):
        return ()
    is_guessed = any(node.kind == "light" and node.is_guess for node in lamp)
    is_lamp = is_guessed or declared_class(device.type) == "light" or set(roles) - {"on_off"}
    return lamp if is_lamp else ()


def _light_roles(node: NodeRoles) -> frozenset[str]:
    return frozenset(role.name for role in node.roles) & set(LIGHT_ROLES)


def _may_be_of_a_lamp(node: NodeRoles) -> bool:
    """Return whether its kind is that of a lamp or unknown: the switch of a pump is no part of a lamp."""
    if node.kind:
        return node.kind == "switch" or node.kind in _lights()
    return tokens_in(node.node.type, node.node.id, node.node.name) <= _GENERAL


_GENERAL = frozenset(
    {"brightness", "channel", "color", "colour", "ct", "dim", "level", "main", "on", "onoff", "output", "power"}
    | {"state", "switch", "temperature", "value", "white"}
)


def _lights() -> frozenset[str]:
    return frozenset(name for name, kind in KINDS.items() if kind.service_type == "light")


def _light(nodes: tuple[NodeRoles, ...]) -> BytesPart:
    props = {role: prop for role in LIGHT_ROLES for node in nodes if (prop := node.prop(role)) is not None}
    part = node_part(nodes[0].node, "light", guessed=any(node.is_guess for node in nodes))
    add_light(part, props)
    return part


def _controls(device: HomieDevice, node: NodeRoles) -> Iterator[BytesPart]:
    props = {role.name: role.prop for role in node.roles if role.name in CONTROLS}
    service_type = _service_type(device, node, props)
    if not service_type:
        return
    tag = KINDS[node.kind].tag if node.kind else ""
    part = node_part(node.node, service_type, tag=tag, guessed=node.is_guess)
    _ADDERS[service_type](part, props)
    if not part.is_empty:
        yield part


def _service_type(device: HomieDevice, node: NodeRoles, props: Mapping[str, HomieProperty]) -> str:
    """Return the service type of the controls of *node*; empty if it has none, or only incomplete ones."""
    kind = KINDS[node.kind].service_type if node.kind else ""
    if props.keys() & _NEEDED.get(kind, frozenset()):
        is_outlet = declared_class(device.type) in _OUTLETS or _OUTLETS & tokens_in(node.node.type, node.node.id)
        return "plug" if kind == "switch" and is_outlet else kind
    for service_type in ("light", "window_covering", "switch"):
        if props.keys() & _NEEDED[service_type]:
            tokens = tokens_in(node.node.type, node.node.id, device.type)
            return "plug" if service_type == "switch" and tokens & _OUTLETS else service_type
    return ""


_NEEDED: Mapping[str, frozenset[str]] = {
    "light": frozenset({"level", "color", "color_temperature"}),
    "window_covering": frozenset({"position", "tilt", "movement", "move"}),
    "closure": frozenset({"position", "movement", "move"}),
    "door_lock": frozenset({"lock", "lock_action"}),
    "water_valve": frozenset({"valve"}),
    "thermostat": THERMOSTAT_ROLES,
    "fan": frozenset({"fan_mode", "fan_speed", "on_off"}),
    "switch": frozenset({"on_off"}),
}


def describe(device: HomieDevice, domain: str, *, is_alive: bool) -> DeviceAnnounced | None:
    """Return the description of *device*; None if it has no parts itself, as a bridge.

    Its identifier is its id in its domain, with a hardware address if the id ends with one. The ``$mac`` of version 4
    belongs to the publishing computer, perhaps of many devices.
    """
    parts = build_parts(device)
    if not parts:
        return None
    return DeviceAnnounced(
        key=device.topic,
        convention="homie",
        native=True,
        whole_device=True,
        identifiers=identifiers((f"{domain}/{device.id}",)),
        name=device.name,
        parts=parts,
        topic=f"{device.topic}/$state",
        facts={**device.facts, **({"type": device.type} if device.type else {})},
        availability=availability_of(device.topic, device.root),
        owns=(device.topic,),
        implies_alive=is_alive,
    )
