"""Robots that clean, as Valetudo announces them. Pure.

Source: Valetudo 2021.10 to 2025, ``backend/lib/mqtt``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_option
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Publication
from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.node_part import node_part
from homebot.conventions.homie.node_types import tokens_in
from homebot.conventions.homie.property_codecs import add_enum
from homebot.conventions.homie.roles import NodeRoles
from homebot.conventions.homie.values import publication, read_plain
from homebot.conventions.part_builder import BytesPart
from homebot.devices.value import PlainValue

__all__ = ["Vacuum", "build_vacuum", "find_vacuum"]


@dataclass(frozen=True, slots=True)
class Vacuum:
    """A robot that cleans.

    Attributes:
        node: The node that takes its orders.
        order: What it does.
        state: What it tells of that; None while it does not.
        power: How strong its fan is; None where that cannot be set.
    """

    node: HomieNode
    order: HomieProperty
    state: HomieProperty | None
    power: HomieProperty | None

    @property
    def props(self) -> tuple[HomieProperty, ...]:
        """All of the above."""
        return tuple(prop for prop in (self.order, self.state, self.power) if prop is not None)


def find_vacuum(nodes: tuple[NodeRoles, ...]) -> Vacuum | None:
    """Return the robot, by the words of its orders and its state; None where the device is none.

    Its state may come later than its orders, which are as clear where they are these four.
    """
    props = [(node.node, role.prop) for node in nodes for role in node.roles if role.prop.datatype == "enum"]
    states = [prop for _, prop in props if not prop.is_settable and {"docked", "cleaning"} <= set(prop.options)]
    orders = [(node, prop) for node, prop in props if prop.is_settable and {"START", "HOME"} <= set(prop.options)]
    if not orders or not (states or set(orders[0][1].options) == set(_ORDERS.values())):
        return None
    node, order = orders[0]
    power = next((prop for one, prop in props if prop.is_settable and "fan" in _spelled(one)), None)
    return Vacuum(node, order, states[0] if states else None, power)


def build_vacuum(vacuum: Vacuum) -> BytesPart:
    """Describe the robot."""
    part = node_part(vacuum.node, "robotic_vacuum_cleaner", guessed=True)
    order, state = vacuum.order, vacuum.state
    orders = {name: option for name, option in _ORDERS.items() if option in order.options}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (publication(order, orders[require_option("vacuum", value, orders)]),)

    if state is not None:
        part.read_from(state.topic, lambda payload: _read(state, payload))
    part.add_command_topics(f"{order.topic}/set")
    part.add_capability("vacuum", readable=state is not None, writer=write)
    if vacuum.power is not None:
        add_enum(part, "fan_mode", vacuum.power)
    return part


_ORDERS = {"cleaning": "START", "paused": "PAUSE", "idle": "STOP", "returning": "HOME"}
_STATES: Mapping[str, str] = {
    "docked": "docked",
    "idle": "idle",
    "returning": "returning",
    "cleaning": "cleaning",
    "paused": "paused",
    "error": "error",
    "moving": "cleaning",
    "manual_control": "cleaning",
}
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def _read(state: HomieProperty, payload: bytes) -> Readings:
    value = read_plain(state, payload)
    return {"vacuum": _STATES[value]} if isinstance(value, str) and value in _STATES else NO_READINGS


def _spelled(node: HomieNode) -> frozenset[str]:
    """The words of a node, also of one that writes ``FanSpeedControlCapability``."""
    return tokens_in(_CAMEL.sub(" ", node.id), node.name)
