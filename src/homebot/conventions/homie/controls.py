"""Covers, locks, valves, thermostats, fans, and robots that clean. Pure.

Source: hc-smarthome v2, shutter, garage-door, lock, valve and thermostat; Valetudo 2021.10 to 2025,
``backend/lib/mqtt``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import require_bool, require_option
from homebot.conventions.description import Publication
from homebot.conventions.homie.model import HomieNode, HomieProperty
from homebot.conventions.homie.node_types import tokens_in
from homebot.conventions.homie.property_codecs import (
    add_enum,
    add_flag,
    add_percent,
    add_temperature,
    percent_of,
    percent_written,
)
from homebot.conventions.homie.roles import NodeRoles
from homebot.conventions.homie.simple_parts import node_part
from homebot.conventions.homie.values import publication, read_plain
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue

__all__ = ["Vacuum", "add_cover", "add_fan", "add_lock", "add_thermostat", "add_valve", "build_vacuum", "find_vacuum"]


Props = Mapping[str, HomieProperty]

_OPENINGS = ("open", "closed", "opening", "closing", "stopped")
_MOVEMENTS = {"open": "open", "close": "closed", "closed": "closed", "stop": "stopped", "up": "open", "down": "closed"}
_MOVES = {"open": ("open", "up"), "closed": ("close", "closed", "down"), "stopped": ("stop", "stopped")}
_LOCKS = {True: "locked", False: "unlocked"}
_LOCK_COMMANDS = {"locked": ("lock", "locked"), "unlocked": ("unlock", "unlocked"), "open": ("open",)}
_VALVES = {True: "open", False: "closed"}


def add_cover(part: BytesPart, props: Props) -> None:
    """Let *part* be a cover. One without orders in words is moved by its position."""
    position, state, order = props.get("position"), props.get("movement"), props.get("move")
    for capability in ("position", "tilt"):
        if capability in props:
            add_percent(part, capability, props[capability])

    def read(prop: HomieProperty, payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        movement = value.casefold() if isinstance(value, str) else ""
        movement = _MOVEMENTS.get(movement, movement)
        return {"movement": movement} if movement in _OPENINGS else NO_READINGS

    def move(prop: HomieProperty, orders: Mapping[str, str], value: PlainValue, _: float) -> tuple[Publication, ...]:
        return (publication(prop, orders[require_option("movement", value, orders)]),)

    def go(prop: HomieProperty, value: PlainValue, _: float) -> tuple[Publication, ...]:
        percent = {"open": 100.0, "closed": 0.0}
        return (percent_written(prop, "position", percent[require_option("movement", value, percent)]),)

    if state is not None:
        part.read_from(state.topic, partial(read, state))
    orders = _options_by_command(order, _MOVES)
    writer = None
    if order is not None and orders:
        part.add_command_topics(f"{order.topic}/set")
        writer = partial(move, order, orders)
    elif position is not None and position.is_settable:
        writer = partial(go, position)
    if state is not None or writer is not None:
        part.add_capability("movement", readable=state is not None, writer=writer, options=_OPENINGS)


def add_lock(part: BytesPart, props: Props) -> None:
    """Let *part* be a lock: locked where its state is true."""
    state, order = props.get("lock"), props.get("lock_action")
    orders = _options_by_command(order, _LOCK_COMMANDS)

    def read(payload: bytes) -> Readings:
        value = read_plain(state, payload) if state is not None else None
        return {"lock": _LOCKS[value]} if isinstance(value, bool) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if state is not None and state.is_settable and value != "open":
            target = require_option("lock", value, ("locked", "unlocked", *(("open",) if "open" in orders else ())))
            return (publication(state, "true" if target == "locked" else "false"),)
        option = orders[require_option("lock", value, orders)]
        return () if order is None else (publication(order, option),)

    if state is not None:
        part.read_from(state.topic, read)
    for prop in (state, order):
        if prop is not None and prop.is_settable:
            part.add_command_topics(f"{prop.topic}/set")
    is_settable = bool(orders) or (state is not None and state.is_settable)
    part.add_capability("lock", readable=state is not None, writer=write if is_settable else None)


def add_valve(part: BytesPart, props: Props) -> None:
    """Let *part* be a valve: open where its state is true."""
    state = props["valve"]

    def read(payload: bytes) -> Readings:
        value = read_plain(state, payload)
        return {"valve": _VALVES[value]} if isinstance(value, bool) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (
            publication(state, "true" if require_option("valve", value, ("open", "closed")) == "open" else "false"),
        )

    part.read_from(state.topic, read)
    if state.is_settable:
        part.add_command_topics(f"{state.topic}/set")
    part.add_capability("valve", writer=write if state.is_settable else None, options=("open", "closed"))


def add_thermostat(part: BytesPart, props: Props) -> None:
    """Let *part* be a thermostat."""
    for capability in ("heating_setpoint", "cooling_setpoint", "local_temperature"):
        if capability in props:
            add_temperature(part, capability, props[capability])
    for capability in ("thermostat_mode", "fan_mode"):
        if capability in props:
            add_enum(part, capability, props[capability])


def add_fan(part: BytesPart, props: Props) -> None:
    """Let *part* be a fan. One without a switch is off at speed 0."""
    speed = props.get("fan_speed")
    if "on_off" in props:
        add_flag(part, props["on_off"])
    elif speed is not None:
        _add_switch_of_speed(part, speed)
    if speed is not None:
        add_percent(part, "fan_speed", speed)
    if "fan_mode" in props:
        add_enum(part, "fan_mode", props["fan_mode"])


def _add_switch_of_speed(part: BytesPart, speed: HomieProperty) -> None:
    def read(payload: bytes) -> Readings:
        percent = percent_of(speed, payload)
        return NO_READINGS if percent is None else {"on_off": percent > 0}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (percent_written(speed, "fan_speed", 100.0 if require_bool("on_off", value) else 0.0),)

    part.read_from(speed.topic, read)
    part.add_capability("on_off", readable=speed.is_retained, writer=write if speed.is_settable else None)


def _options_by_command(prop: HomieProperty | None, spellings: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    """The word of *prop* for each thing that it may be told."""
    if prop is None:
        return {}
    by_name = {option.casefold(): option for option in prop.options}
    return {
        meaning: by_name[name]
        for meaning, spelled in spellings.items()
        if (name := next((one for one in spelled if one in by_name), ""))
    }


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
