"""Alarms, lamps, covers, locks, fans, and robots that clean: controls of several properties. Pure.

Source: homie5-device-profiles, Light; hc-smarthome v2, switch, level, color, shutter, garage-door and lock; Valetudo
2021.10 to 2025, ``backend/lib/mqtt``.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from homebot.conventions.command_values import bool_writer, option_writer, require_option
from homebot.conventions.description import Publications
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue
from homebot.integrations.homie.formats.model import HomieNode, HomieProperty
from homebot.integrations.homie.formats.properties import (
    add_properties,
    add_property,
    node_part,
    percent_of,
    percent_written,
    publication,
    read_color,
    read_plain,
)
from homebot.integrations.homie.formats.roles import NodeRoles, tokens_in

Props = Mapping[str, HomieProperty]
_NodeProperty: TypeAlias = tuple[HomieNode, HomieProperty]

LIGHT_ROLES = ("on_off", "level", "color", "color_temperature")
"""Roles that a lamp may have, each once."""

_OPENINGS = ("open", "closed", "opening", "closing", "stopped")
_MOVEMENTS = {"open": "open", "close": "closed", "closed": "closed", "stop": "stopped", "up": "open", "down": "closed"}
_MOVES = {"open": ("open", "up"), "closed": ("close", "closed", "down"), "stopped": ("stop", "stopped")}
_PERCENTS = {"open": 100.0, "closed": 0.0}
_LOCKS = {True: "locked", False: "unlocked"}
_LOCK_STATES = frozenset({"locked", "unlocked", "locking", "unlocking", "open", "opening", "jammed"})
_LOCK_COMMANDS = {"locked": ("lock", "locked"), "unlocked": ("unlock", "unlocked"), "open": ("open",)}


def add_cover(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a cover. Without an enum of commands it is moved by its position."""
    position, state, command = props.get("position"), props.get("movement"), props.get("move")
    add_properties(part, props, "position", "tilt")
    if state is not None:
        part.read_from(state.topic, partial(_read_movement, state))
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


def add_lift(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a lift, whose door has one property for its state and its commands."""
    add_properties(part, props, "floor", "session")
    if (door := props.get("movement")) is not None:
        add_cover(part, {"movement": door, "move": door} if door.is_settable else {"movement": door})


def _read_movement(state: HomieProperty, payload: bytes) -> Readings:
    value = read_plain(state, payload)
    movement = value.casefold() if isinstance(value, str) else ""
    movement = _MOVEMENTS.get(movement, movement)
    return {"movement": movement} if movement in _OPENINGS else NO_READINGS


def add_lock(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a lock, which is locked if its state is true, or says so.

    An enum of states that can be set is its state too, if there is no other.
    """
    state, command = props.get("lock"), props.get("lock_action")
    commands = _options_by_command(command, _LOCK_COMMANDS)
    told_by_command = (
        command is not None
        and command.is_retained
        and {*_LOCKS.values()} <= {option.casefold() for option in command.options}
    )
    reported = command if state is None and told_by_command else state

    def read(payload: bytes) -> Readings:
        value = read_plain(reported, payload) if reported is not None else None
        if isinstance(value, bool):
            return {"lock": _LOCKS[value]}
        state = value.casefold() if isinstance(value, str) else ""
        return {"lock": state} if state in _LOCK_STATES else NO_READINGS

    def write(value: PlainValue, _transition: float) -> Publications:
        if state is not None and state.is_settable and value != "open":
            target = require_option("lock", value, ("locked", "unlocked", *(("open",) if "open" in commands else ())))
            return (publication(state, state.flags[target == "locked"]),)
        option = commands[require_option("lock", value, commands)]
        return () if command is None else (publication(command, option),)

    if reported is not None:
        part.read_from(reported.topic, read)
    for prop in (state, command):
        if prop is not None and prop.is_settable:
            part.add_command_topics(f"{prop.topic}/set")
    is_settable = bool(commands) or (state is not None and state.is_settable)
    part.add_capability("lock", readable=reported is not None, writer=write if is_settable else None)


def add_alarm(part: BytesPart, props: Props) -> None:
    """Add the state of an alarm, which is that of its commands if there is no other, and the states to set."""
    command = props.get("arm")
    state = props.get("alarm", command)
    if state is None:
        return

    def read(payload: bytes) -> Readings:
        value = read_plain(state, payload)
        return {"alarm": value.casefold()} if isinstance(value, str) else NO_READINGS

    part.read_from(state.topic, read)
    writer = None
    if command is not None:
        options = {option.casefold(): option for option in command.options}
        part.add_command_topics(f"{command.topic}/set")
        writer = option_writer("alarm", options, lambda option: (publication(command, options[option]),))
    part.add_capability("alarm", writer=writer, options=tuple(option.casefold() for option in state.options))


def add_light(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a lamp. Setting brightness or colour also switches it on: Homie leaves that to us."""
    switch, level, color = (props.get(role) for role in ("on_off", "level", "color"))
    on: Publications = ()
    off: Publications = ()
    if switch is not None and switch.is_settable:
        off, on = (publication(switch, switch.flags[0]),), (publication(switch, switch.flags[1]),)
    add_properties(part, props, "on_off")
    if level is not None:
        add_property(part, "level", level, on=on, off=off)
        if switch is None:
            _add_switch_of_range(part, "level", level)
    if color is not None:
        add_property(part, "color", color, on=on)
        if level is None and set(color.options) & {"hsv", "rgb"}:
            part.read_from(color.topic, partial(_read_brightness, color))
            part.add_capability("level")
    if "color_temperature" in props:
        add_property(part, "color_temperature", props["color_temperature"], on=on)


def _read_brightness(color: HomieProperty, payload: bytes) -> Readings:
    value = read_color(color, payload)
    return NO_READINGS if value is None or value[2] is None else {"level": value[2]}


def add_fan(part: BytesPart, props: Props) -> None:
    """Add the capabilities of a fan. Without a switch it is off at speed 0."""
    if "on_off" not in props and "fan_speed" in props and not props["fan_speed"].range.least:
        _add_switch_of_range(part, "fan_speed", props["fan_speed"])
    add_properties(part, props, "on_off", "fan_speed", "fan_mode")


def _add_switch_of_range(part: BytesPart, capability: str, prop: HomieProperty) -> None:
    def read(payload: bytes) -> Readings:
        percent = percent_of(prop, read_plain(prop, payload))
        return NO_READINGS if percent is None else {"on_off": percent > 0}

    part.read_from(prop.topic, read)
    writer = bool_writer("on_off", lambda on: (percent_written(prop, capability, 100.0 if on else 0.0),))
    part.add_capability("on_off", readable=prop.is_retained, writer=writer if prop.is_settable else None)


def _options_by_command(prop: HomieProperty | None, spellings: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    if prop is None:
        return {}
    by_name = {option.casefold(): option for option in prop.options}
    return {
        meaning: by_name[name]
        for meaning, spelled in spellings.items()
        if (name := next((spelling for spelling in spelled if spelling in by_name), ""))
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
        return tuple(prop for prop in (self.command, self.state, self.power) if prop is not None)


def find_vacuum(nodes: tuple[NodeRoles, ...]) -> _Vacuum | None:
    """Return the robot, by the options of its commands and its state; None for other devices.

    Before its state is announced, exactly these four commands identify it.
    """
    state = next((prop for _, prop in _enums(nodes, {"docked", "cleaning"}, settable=False)), None)
    node, command = next(_enums(nodes, {"START", "HOME"}, settable=True), (None, None))
    if node is None or command is None or (state is None and set(command.options) != set(_COMMANDS.values())):
        return None
    power = None
    for owner, prop in _enums(nodes, set(), settable=True):
        if "fan" in tokens_in(_CAMEL.sub(" ", owner.id), owner.name):  # also FanSpeedControlCapability
            power = prop
            break
    return _Vacuum(node, command, state, power)


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
        add_property(part, "fan_mode", vacuum.power)
    return part


def _enums(nodes: Iterable[NodeRoles], options: AbstractSet[str], *, settable: bool) -> Iterator[_NodeProperty]:
    """Yield the enums with these *options*, and perhaps others, with their nodes."""
    for node in nodes:
        for prop in (role.prop for role in node.roles):
            if prop.datatype == "enum" and prop.is_settable == settable and options <= set(prop.options):
                yield node.node, prop


_COMMANDS = {"cleaning": "START", "paused": "PAUSE", "idle": "STOP", "returning": "HOME"}
_STATES: Mapping[str, str] = {
    **{state: state for state in ("docked", "idle", "returning", "cleaning", "paused", "error")},
    **dict.fromkeys(("moving", "manual_control"), "cleaning"),
}
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def _read(state: HomieProperty, payload: bytes) -> Readings:
    value = read_plain(state, payload)
    return {"vacuum": _STATES[value]} if isinstance(value, str) and value in _STATES else NO_READINGS
