"""The component ``valve``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/valve.py`` and ``components/valve/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity, Scale
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import NO_READINGS, Readings, fields_of, number_of
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["build_valve"]


def build_valve(config: DiscoveryConfig) -> DescribedPart:
    """Describe a valve, perhaps with a position."""
    scale = Scale(config.integer("position_closed", 0), config.integer("position_open", 100))
    variables = {"position_open": scale.full, "position_closed": scale.zero}
    has_position = config.flag("reports_position")
    command = config.command("command_topic")
    payloads = {
        state: payload
        for state, (key, default) in _COMMANDS.items()
        if (payload := config.payload(key, default)) is not None
    }
    if not config.has("payload_stop"):
        payloads.pop("stopped", None)
    if has_position:
        for key in _NO_POSITION:
            if key in config.values:
                raise WireError(f"valve: {key} is not allowed for a valve that reports its position")
    decoder = _ValveStateDecoder({config.text(f"state_{state}", state): state for state in _STATES}, scale)
    commands = (
        None if command is None else _ValveCommands(command, payloads, scale if has_position else None, variables)
    )
    entity = Entity(config, "water_valve")
    readable = entity.read_text_from(
        config.source("state_topic", variables=variables), decoder.read_position if has_position else decoder.read_state
    )
    entity.add_capability("valve", readable=readable, writer=commands.move if commands else None)
    if has_position:
        entity.add_capability("position", readable=readable, writer=commands.set_position if commands else None)
    entity.add_commands(command)
    return entity.build()


_STATES = ("closed", "open", "closing", "opening")
"""Of two states with the same payload the later one counts."""

_COMMANDS = {"open": ("payload_open", "OPEN"), "closed": ("payload_close", "CLOSE"), "stopped": ("payload_stop", "")}
_NO_POSITION = ("payload_open", "payload_close", "state_open", "state_closed")
_MOVING = frozenset({"opening", "closing"})
_ENDS = (0.0, 100.0)


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
