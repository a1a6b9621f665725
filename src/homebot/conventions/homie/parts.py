"""Parts of a Homie device, and the device as the gateway takes it. Pure.

Each node's controls are one part, each value that it only reports another, and each further value that can be set a
setting. The switch, the brightness and the colour of a lamp are one part, although they are nodes of their own. Of a
robot that cleans, the nodes that declare no other kind are settings: the power of its fan makes it no fan.
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
    """Return the parts of *device*; first what it is there for."""
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
    """Return the nodes that together are one lamp; none where there is none, or more than one."""
    found = tuple(
        node for node in nodes if any(role.name in LIGHT_ROLES for role in node.roles) and _may_be_of_a_lamp(node)
    )
    counts = [sum(1 for node in found if node.prop(role) is not None) for role in LIGHT_ROLES]
    if any(count > 1 for count in counts):
        return ()
    is_lamp = declared_class(device.type) == "light" or any(counts[1:])
    is_lamp = is_lamp or any(node.kind == "light" and node.is_guess for node in found)
    return found if is_lamp else ()


def _may_be_of_a_lamp(node: NodeRoles) -> bool:
    """Return whether its kind says so, or nothing else: a pump's switch is not that of the lamp beside it."""
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
    """Return the type of the controls of *node*; empty where it has none, or only some that mean nothing alone."""
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
    """Return the description of *device*; None where it offers nothing itself, as a bridge does.

    Who it is, is its id in its domain: a hardware address counts where the id ends with one. The ``$mac`` of version 4
    is that of the computer that publishes for it, and perhaps for many.
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
