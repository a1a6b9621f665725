"""Parts of a node besides its controls: its meters, its sensors and its settings. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.property_codecs import add_plain, add_press, add_temperature
from homebot.conventions.homie.roles import CONTROLS, THERMOSTAT_ROLES, NodeRoles, Role
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.units import sensor_type
from homebot.devices.part import Category

__all__ = ["build_meters", "build_singles", "node_part"]


def node_part(
    node: HomieNode,
    service_type: str,
    *,
    suffix: str = "",
    name: str = "",
    tag: str = "",
    category: Category = "",
    guessed: bool = False,
) -> BytesPart:
    """Return a part of *node* without capabilities; its *suffix* is empty for the main part of the node.

    The other arguments are fields of :class:`homebot.devices.part.Part`.
    """
    return BytesPart(
        "/".join(_filled((node.id, suffix))),
        service_type,
        name=" ".join(dict.fromkeys(_filled((node.name, name)))),
        advertised=node.type,
        tag=tag,
        category=category,
        guessed=guessed,
    )


def _filled(texts: Iterable[str]) -> tuple[str, ...]:
    return tuple(text for text in texts if text)


_ELECTRICAL = frozenset({"power", "energy", "voltage", "current", "frequency"})
_DIAGNOSTIC = frozenset({"battery", "battery_low", "signal_strength"})
_SETTINGS: Mapping[str, str] = {"boolean": "state", "integer": "number", "float": "number", "enum": "option"}


def build_meters(node: NodeRoles) -> Iterator[BytesPart]:
    """Describe the electrical measurements of a node as one meter."""
    roles = {role.name: role for role in reversed(node.roles) if role.name in _ELECTRICAL}
    if not roles:
        return
    part = node_part(
        node.node, "electrical_meter", suffix="$meter", guessed=any(role.is_guess for role in roles.values())
    )
    for role in reversed(roles.values()):
        add_plain(part, role.name, role.prop)
    yield part


def build_singles(node: NodeRoles) -> Iterator[BytesPart]:
    """Describe the other properties of a node: sensors and settings, each a part."""
    has_thermostat = any(role.name in THERMOSTAT_ROLES for role in node.roles)
    metered: set[str] = set()
    for role in node.roles:
        if role.name in _ELECTRICAL and role.name not in metered:
            metered.add(role.name)
        elif role.name == "local_temperature":
            if not has_thermostat:
                yield _sensor(node.node, Role("temperature", role.prop, role.is_guess))
        elif role.name and role.name not in CONTROLS:
            yield _sensor(node.node, role)
        elif not role.name and not _is_relative(role.prop):
            yield _setting(node.node, role.prop)


def _is_relative(prop: HomieProperty) -> bool:
    """Return whether all its commands are relative; homebot's commands are absolute."""
    return prop.datatype == "enum" and not prop.is_retained and set(prop.options) <= _RELATIVE


_RELATIVE = frozenset({"toggle", "brighter", "darker", "step-up", "step-down", "trigger"})


def _sensor(node: HomieNode, role: Role) -> BytesPart:
    category: Category = "diagnostic" if role.name in _DIAGNOSTIC else ""
    service_type = sensor_type(role.name)
    part = node_part(
        node, service_type, suffix=role.prop.id, name=role.prop.name, category=category, guessed=role.is_guess
    )
    if role.name == "press":
        add_press(part, role.prop)
    elif role.name == "temperature":
        add_temperature(part, role.name, role.prop)
    else:
        add_plain(part, role.name, role.prop)
    return part


def _setting(node: HomieNode, prop: HomieProperty) -> BytesPart:
    part = node_part(node, "x_setting", suffix=prop.id, name=prop.name, category="config")
    add_plain(part, _SETTINGS.get(prop.datatype, "text"), prop)
    return part
