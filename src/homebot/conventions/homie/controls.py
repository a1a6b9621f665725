"""Covers, locks, valves, thermostats, fans, and robots that clean. Pure.

Source: hc-smarthome v2, shutter, garage-door, lock, valve and thermostat; Valetudo 2021.10 to 2025,
``backend/lib/mqtt``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import bool_writer, option_writer, require_option
from homebot.conventions.description import Publications
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

__all__ = ["add_cover", "add_fan", "add_lock", "add_thermostat", "add_valve", "build_vacuum", "find_vacuum"]


Props = Mapping[str, HomieProperty]

_OPENINGS = ("open", "closed", "opening", "closing", "stopped")
_MOVEMENTS = {"open": "open", "close": "closed", "closed": "closed", "stop": "stopped", "up": "open", "down": "closed"}
_MOVES = {"open": ("open", "up"), "closed": ("close", "closed", "down"), "stopped": ("stop", "stopped")}
_PERCENTS = {"open": 100.0, "closed": 0.0}
_LOCKS = {True: "locked", False: "unlocked"}
_LOCK_COMMANDS = {"locked": ("lock", "locked"), "unlocked": ("unlock", "unlocked"), "open": ("open",)}
_VALVES = {True: "open", False: "closed"}


def add_cover(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a cover. Without an enum of commands it is moved by its position."""
    position, state, command = props.get("position"), props.get("movement"), props.get("move")
    for capability in ("position", "tilt"):
        if capability in props:
            add_percent(part, capability, props[capability])

    def read(prop: HomieProperty, payload: bytes) -> Readings:
        value = read_plain(prop, payload)
        movement = value.casefold() if isinstance(value, str) else ""
        movement = _MOVEMENTS.get(movement, movement)
        return {"movement": movement} if movement in _OPENINGS else NO_READINGS

    if state is not None:
        part.read_from(state.topic, partial(read, state))
    options = _options_by_command(command, _MOVES)
    writer = None
    if command is not None and options:
        part.add_command_topics(f"{command.topic}/set")
        writer = option_writer("movement", options, lambda movement: (publication(command, options[movement]),))
    elif position is not None and position.is_settable:
        writer = option_writer(
            "movement", _PERCENTS, lambda movement: (percent_written(position, "position", _PERCENTS[movement]),)
        )
    if state is not None or writer is not None:
        part.add_capability("movement", readable=state is not None, writer=writer, options=_OPENINGS)


def add_lock(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a lock, which is locked if its state is true."""
    state, command = props.get("lock"), props.get("lock_action")
    commands = _options_by_command(command, _LOCK_COMMANDS)

    def read(payload: bytes) -> Readings:
        value = read_plain(state, payload) if state is not None else None
        return {"lock": _LOCKS[value]} if isinstance(value, bool) else NO_READINGS

    def write(value: PlainValue, _transition: float) -> Publications:
        if state is not None and state.is_settable and value != "open":
            target = require_option("lock", value, ("locked", "unlocked", *(("open",) if "open" in commands else ())))
            return (publication(state, "true" if target == "locked" else "false"),)
        option = commands[require_option("lock", value, commands)]
        return () if command is None else (publication(command, option),)

    if state is not None:
        part.read_from(state.topic, read)
    for prop in (state, command):
        if prop is not None and prop.is_settable:
            part.add_command_topics(f"{prop.topic}/set")
    is_settable = bool(commands) or (state is not None and state.is_settable)
    part.add_capability("lock", readable=state is not None, writer=write if is_settable else None)


def add_valve(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a valve, which is open if its state is true."""
    state = props["valve"]

    def read(payload: bytes) -> Readings:
        value = read_plain(state, payload)
        return {"valve": _VALVES[value]} if isinstance(value, bool) else NO_READINGS

    def publish(target: str) -> Publications:
        return (publication(state, "true" if target == "open" else "false"),)

    part.read_from(state.topic, read)
    if state.is_settable:
        part.add_command_topics(f"{state.topic}/set")
    writer = option_writer("valve", ("open", "closed"), publish) if state.is_settable else None
    part.add_capability("valve", writer=writer, options=("open", "closed"))


def add_thermostat(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a thermostat."""
    for capability in ("heating_setpoint", "cooling_setpoint", "local_temperature"):
        if capability in props:
            add_temperature(part, capability, props[capability])
    for capability in ("thermostat_mode", "fan_mode"):
        if capability in props:
            add_enum(part, capability, props[capability])


def add_fan(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a fan. Without a switch it is off at speed 0."""
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

    part.read_from(speed.topic, read)
    writer = bool_writer("on_off", lambda on: (percent_written(speed, "fan_speed", 100.0 if on else 0.0),))
    part.add_capability("on_off", readable=speed.is_retained, writer=writer if speed.is_settable else None)


def _options_by_command(prop: HomieProperty | None, spellings: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    """Return the option of *prop* for each command."""
    if prop is None:
        return {}
    by_name = {option.casefold(): option for option in prop.options}
    return {
        meaning: by_name[name]
        for meaning, spelled in spellings.items()
        if (name := next((one for one in spelled if one in by_name), ""))
    }


@dataclass(frozen=True, slots=True)
class _Vacuum:
    """A robot that cleans: the properties of its commands, its state and its power, and the node of its commands."""

    node: HomieNode
    command: HomieProperty
    state: HomieProperty | None
    power: HomieProperty | None

    @property
    def props(self) -> tuple[HomieProperty, ...]:
        """Its properties."""
        return tuple(prop for prop in (self.command, self.state, self.power) if prop is not None)


def find_vacuum(nodes: tuple[NodeRoles, ...]) -> _Vacuum | None:
    """Return the robot, by the options of its commands and its state; None for other devices.

    Before its state is announced, exactly these four commands identify it.
    """
    props = [(node.node, role.prop) for node in nodes for role in node.roles if role.prop.datatype == "enum"]
    states = [prop for _, prop in props if not prop.is_settable and {"docked", "cleaning"} <= set(prop.options)]
    commands = [(node, prop) for node, prop in props if prop.is_settable and {"START", "HOME"} <= set(prop.options)]
    if not commands or not (states or set(commands[0][1].options) == set(_COMMANDS.values())):
        return None
    node, command = commands[0]
    power = next((prop for owner, prop in props if prop.is_settable and "fan" in _words(owner)), None)
    return _Vacuum(node, command, states[0] if states else None, power)


def build_vacuum(vacuum: _Vacuum) -> BytesPart:
    """Describe the robot."""
    part = node_part(vacuum.node, "robotic_vacuum_cleaner", guessed=True)
    command, state = vacuum.command, vacuum.state
    options = {name: option for name, option in _COMMANDS.items() if option in command.options}
    if state is not None:
        part.read_from(state.topic, lambda payload: _read(state, payload))
    part.add_command_topics(f"{command.topic}/set")
    writer = option_writer("vacuum", options, lambda state: (publication(command, options[state]),))
    part.add_capability("vacuum", readable=state is not None, writer=writer, options=tuple(options))
    if vacuum.power is not None:
        add_enum(part, "fan_mode", vacuum.power)
    return part


_COMMANDS = {"cleaning": "START", "paused": "PAUSE", "idle": "STOP", "returning": "HOME"}
_STATES: Mapping[str, str] = {
    **{state: state for state in ("docked", "idle", "returning", "cleaning", "paused", "error")},
    **dict.fromkeys(("moving", "manual_control"), "cleaning"),
}
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def _read(state: HomieProperty, payload: bytes) -> Readings:
    value = read_plain(state, payload)
    return {"vacuum": _STATES[value]} if isinstance(value, str) and value in _STATES else NO_READINGS


def _words(node: HomieNode) -> frozenset[str]:
    """Return the words of a node, also of one that writes ``FanSpeedControlCapability``."""
    return tokens_in(_CAMEL.sub(" ", node.id), node.name)
