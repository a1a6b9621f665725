"""Covers and valves: blinds, shutters, gates and doors that a motor moves, and valves with or without a position. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/cover.py`` and ``valve.py``, ``components/valve/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import Writer, number_writer, option_writer, require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.device_classes import CLOSURE_CLASSES
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity, Scale
from homebot.conventions.homeassistant.topics import CommandTopic, ValueSource
from homebot.conventions.payload import NO_READINGS, Readings, fields_of, number_of
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["build_cover", "build_valve"]

_STATES = ("closed", "open", "closing", "opening", "stopped")
"""The later of two states with the same payload counts; a valve has no last one."""


def _scale(config: DiscoveryConfig) -> Scale:
    return Scale(config.integer("position_closed", 0), config.integer("position_open", 100))


def _variables(scale: Scale) -> dict[str, object]:
    """Return the variables of every template."""
    return {"position_open": scale.full, "position_closed": scale.zero}


def _payloads(config: DiscoveryConfig, *, stop: str) -> dict[str, str]:
    """Return the payload of each command; a field of null removes it."""
    defaults = {
        "open": ("payload_open", "OPEN"),
        "closed": ("payload_close", "CLOSE"),
        "stopped": ("payload_stop", stop),
    }
    payloads = {state: config.payload(key, default) for state, (key, default) in defaults.items()}
    return {state: payload for state, payload in payloads.items() if payload is not None}


def build_cover(config: DiscoveryConfig) -> DescribedPart:
    """Describe a window covering, or a closure where its class is one."""
    scale, tilt_scale = _scale(config), Scale(config.integer("tilt_min", 0), config.integer("tilt_max", 100))
    variables = {**_variables(scale), "tilt_min": tilt_scale.zero, "tilt_max": tilt_scale.full}
    decoder = _CoverStateDecoder(
        scale,
        tilt_scale,
        states={config.text(f"state_{state}", state): state for state in _STATES} | {"None": None},
        state=config.source("state_topic"),
        position=config.source("position_topic", "position_template", variables),
    )
    tilt = config.source("tilt_status_topic", "tilt_status_template", variables)
    entity = Entity(config, "closure" if config.text("device_class") in CLOSURE_CLASSES else "window_covering")
    has_position = entity.read_text_from(decoder.position, decoder.read_position)
    state = entity.usable(decoder.state)
    if state is not None:
        entity.read_from(state.topic, partial(decoder.read_state, state))
    has_tilt = entity.read_text_from(tilt, decoder.read_tilt)

    move = config.command("command_topic", template_key="")
    payloads = _payloads(config, stop="STOP")
    writer = option_writer("movement", payloads, lambda movement: move.publish(payloads[movement])) if move else None
    set_position = config.command("set_position_topic", "set_position_template")
    set_tilt = config.command("tilt_command_topic", "tilt_command_template")
    entity.add_capability("movement", readable=state is not None or has_position, writer=writer if payloads else None)
    entity.add_capability(
        "position",
        readable=has_position,
        writer=_setter("position", set_position, scale, variables),
    )
    entity.add_capability("tilt", readable=has_tilt, writer=_setter("tilt", set_tilt, tilt_scale, variables))
    entity.add_commands(move, set_position, set_tilt)
    return entity.build()


_ENDS: Mapping[float | None, str] = {0.0: "closed", 100.0: "open"}
_LEAVES: Mapping[float, str] = {0.0: "opening", 100.0: "closing"}
"""By position: the movement of a cover that leaves an end."""


@dataclass(slots=True)
class _CoverStateDecoder:
    """Reader of a cover's state and position.

    Many covers only report a stopped motor. They are open or closed by their position at an end, which comes in the
    same message, or in one before or after it.
    """

    scale: Scale
    tilt_scale: Scale
    states: Mapping[str, str | None]
    state: ValueSource | None
    position: ValueSource | None
    _percent: float | None = None  # the last position; None after it began to leave an end
    _movement: str | None = None
    _is_settling: bool = False  # stopped, perhaps before the report of its position

    def read_state(self, state: ValueSource, payload: bytes) -> Readings:
        """Read the state; a stopped cover is closed at position 0 in the same message, and otherwise open."""
        text = state.text(payload)
        if text is None or text not in self.states:
            return NO_READINGS
        before, self._movement = self._movement, self.states[text]
        movement = self._movement
        if self._percent is not None and movement == _LEAVES.get(self._percent):
            self._percent = None
        self._is_settling = movement == "stopped" and (self._percent is None or before in _LEAVES.values())
        if movement == "stopped" and self.position is not None:
            if not self._is_of_one_message:
                return {"movement": _ENDS.get(self._percent, movement)}
            beside = self.position.text(payload)
            known = self.read_position(beside).get("position") if beside else None
            if known is not None:
                movement = "open" if known else "closed"
        return {"movement": movement}

    @property
    def _is_of_one_message(self) -> bool:
        return self.state is not None and self.position is not None and self.state.topic == self.position.topic

    def read_position(self, text: str) -> Readings:
        """Read the position, and the movement of a cover that reports no state or only that it stopped."""
        value: object = text
        found: dict[str, PlainValue] = {}
        if text.startswith("{"):
            message = fields_of(text)
            if "position" not in message:
                return NO_READINGS
            found.update(self.read_tilt(message.get("tilt_position")))
            value = message["position"]
        number = number_of(value)
        if number is None:
            return NO_READINGS
        self._percent = percent = min(100.0, max(0.0, self.scale.percent(number)))
        found["position"] = percent
        if self.state is None:
            found["movement"] = "open" if percent else "closed"
        elif self._is_settling and not self._is_of_one_message:
            found["movement"] = _ENDS.get(percent, "stopped")
        return found

    def read_tilt(self, value: object) -> Readings:
        number = number_of(value)
        scale = self.tilt_scale
        if number is None or not min(scale.zero, scale.full) <= round(number) <= max(scale.zero, scale.full):
            return NO_READINGS
        return {"tilt": scale.percent(round(number))}


def _setter(name: str, command: CommandTopic | None, scale: Scale, variables: Mapping[str, object]) -> Writer | None:
    """Return the writer of a percentage, which is also a variable of the template."""
    if command is None:
        return None
    seen_as = "tilt_position" if name == "tilt" else name

    def publish(number: float) -> Publications:
        percent = round(number)
        return command.publish(round(scale.value(percent)), {seen_as: percent, **variables})

    return number_writer(name, (0, 100), "%", publish)


def build_valve(config: DiscoveryConfig) -> DescribedPart:
    """Describe a valve, perhaps with a position."""
    scale = _scale(config)
    variables = _variables(scale)
    has_position = config.flag("reports_position")
    command = config.command("command_topic")
    payloads = _payloads(config, stop="")
    if not config.has("payload_stop"):
        payloads.pop("stopped", None)
    forbidden = next((key for key in _NO_POSITION if key in config.values), "")
    if has_position and forbidden:
        raise WireError(f"valve: {forbidden} is not allowed for a valve that reports its position")
    decoder = _ValveStateDecoder({config.text(f"state_{state}", state): state for state in _STATES[:-1]}, scale)
    move = set_position = None
    if command is not None:
        commands = _ValveCommands(command, payloads, scale if has_position else None, variables)
        move, set_position = commands.move, commands.set_position
    entity = Entity(config, "water_valve")
    readable = entity.read_text_from(
        config.source("state_topic", variables=variables), decoder.read_position if has_position else decoder.read_state
    )
    entity.add_capability("valve", readable=readable, writer=move)
    if has_position:
        entity.add_capability("position", readable=readable, writer=set_position)
    entity.add_commands(command)
    return entity.build()


_NO_POSITION = ("payload_open", "payload_close", "state_open", "state_closed")
_MOVING = frozenset({"opening", "closing"})


@dataclass(frozen=True, slots=True)
class _ValveStateDecoder:
    """Reader of plain texts and numbers, or of an object with ``state`` and ``position``."""

    states: Mapping[str, str]
    scale: Scale

    def read_state(self, text: str) -> Readings:
        """Read the state of a valve that does not report its position."""
        state = fields_of(text).get("state") if text.startswith("{") else text
        if not isinstance(state, str):
            return NO_READINGS
        if state == "None":
            return {"valve": None}
        return {"valve": self.states[state]} if state in self.states else NO_READINGS

    def read_position(self, text: str) -> Readings:
        """Read the position of a valve that reports it."""
        state: object = text
        position: object = text
        if text.startswith("{"):
            message = fields_of(text)
            if "position" not in message:
                return NO_READINGS
            state, position = message.get("state"), message["position"]
        if state == "None":
            return {"position": None, "valve": None}
        found: dict[str, PlainValue] = {}
        number = number_of(position)
        if number is not None:
            percent = min(100.0, max(0.0, self.scale.percent(number)))
            found = {"position": percent, "valve": "open" if percent else "closed"}
        moving = self.states.get(state) if isinstance(state, str) else None
        if moving in _MOVING:
            found["valve"] = moving
        return found


@dataclass(frozen=True, slots=True)
class _ValveCommands:
    """Writers of a valve. With a scale, open and closed are positions."""

    command: CommandTopic
    payloads: Mapping[str, str]
    scale: Scale | None
    variables: Mapping[str, object]

    def move(self, value: PlainValue, transition: float) -> Publications:
        state = require_option("valve", value, self.payloads)
        if self.scale is not None and state != "stopped":
            return self.set_position(100.0 if state == "open" else 0.0, transition)
        return self.command.publish(self.payloads[state])

    def set_position(self, value: PlainValue, _transition: float) -> Publications:
        percent = round(require_number("position", value, 0, 100, "%"))
        scaled = percent if self.scale is None else round(self.scale.value(percent))
        return self.command.publish(scaled, {"position": percent, **self.variables})
