"""The component ``cover``: blinds and shutters, but also gates and doors that a motor moves. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/cover.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import Writer, number_writer, option_writer
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.device_classes import CLOSURE_CLASSES
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity, Scale
from homebot.conventions.homeassistant.topics import CommandTopic, StateMessage, ValueSource
from homebot.conventions.payload import NO_READINGS, Readings, fields_of, number_of
from homebot.devices.value import PlainValue

__all__ = ["build_cover"]


def build_cover(config: DiscoveryConfig) -> DescribedPart:
    """Describe a window covering, or a closure where its class is one."""
    steps = _Steps(
        Scale(config.integer("position_closed", 0), config.integer("position_open", 100)),
        Scale(config.integer("tilt_min", 0), config.integer("tilt_max", 100)),
    )
    decoder = _CoverStateDecoder(
        steps,
        states={config.text(f"state_{state}", state): state for state in _STATES} | {"None": None},
        state=config.source("state_topic"),
        position=config.source("position_topic", "position_template", steps.variables),
    )
    tilt = config.source("tilt_status_topic", "tilt_status_template", steps.variables)
    entity = Entity(config, "closure" if config.text("device_class") in CLOSURE_CLASSES else "window_covering")
    has_position = entity.read_text_from(decoder.position, decoder.read_position)
    has_state = entity.read_message_from(decoder.state, decoder.read_state)
    has_tilt = entity.read_text_from(tilt, decoder.read_tilt)

    move = config.command("command_topic", template_key="")
    set_position = config.command("set_position_topic", "set_position_template")
    set_tilt = config.command("tilt_command_topic", "tilt_command_template")
    entity.add_capability("movement", readable=has_state or has_position, writer=_mover(config, move))
    entity.add_capability(
        "position",
        readable=has_position,
        writer=_setter("position", set_position, steps.position, steps.variables),
    )
    entity.add_capability("tilt", readable=has_tilt, writer=_setter("tilt", set_tilt, steps.tilt, steps.variables))
    entity.add_commands(move, set_position, set_tilt)
    return entity.build()


_STATES = ("closed", "open", "closing", "opening", "stopped")
"""The later of two states with the same payload counts."""

_ENDS: Mapping[float | None, str] = {0.0: "closed", 100.0: "open"}
_LEAVES: Mapping[float, str] = {0.0: "opening", 100.0: "closing"}
"""By position: the movement of a cover that leaves an end."""

_COMMANDS = {
    "open": ("payload_open", "OPEN"),
    "closed": ("payload_close", "CLOSE"),
    "stopped": ("payload_stop", "STOP"),
}


@dataclass(frozen=True, slots=True)
class _Steps:
    """The device's own numbers for its position and its tilt."""

    position: Scale
    tilt: Scale

    @property
    def variables(self) -> Mapping[str, object]:
        """Variables that every template of a cover may use."""
        return {
            "position_open": self.position.full,
            "position_closed": self.position.zero,
            "tilt_min": self.tilt.zero,
            "tilt_max": self.tilt.full,
        }


@dataclass(slots=True)
class _CoverStateDecoder:
    """Reader of a cover's state and position.

    Many covers only report a stopped motor. They are open or closed by their position at an end, which comes in the
    same message, or in one before or after it.
    """

    steps: _Steps
    states: Mapping[str, str | None]
    state: ValueSource | None
    position: ValueSource | None
    _percent: float | None = None  # the last position; None after it began to leave an end
    _movement: str | None = None
    _is_settling: bool = False  # stopped, perhaps before the report of its position

    def read_state(self, message: StateMessage, text: str) -> Readings:
        """Read the state; a stopped cover is closed at position 0 in the same message, and otherwise open."""
        if text not in self.states:
            return NO_READINGS
        before, self._movement = self._movement, self.states[text]
        movement = self._movement
        if self._percent is not None and movement == _LEAVES.get(self._percent):
            self._percent = None
        self._is_settling = movement == "stopped" and (self._percent is None or before in _LEAVES.values())
        if movement == "stopped" and self.position is not None:
            if not self._is_of_one_message:
                return {"movement": _ENDS.get(self._percent, movement)}
            beside = self.position.text(message)
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
        self._percent = percent = min(100.0, max(0.0, self.steps.position.percent(number)))
        found["position"] = percent
        if self.state is None:
            found["movement"] = "open" if percent else "closed"
        elif self._is_settling and not self._is_of_one_message:
            found["movement"] = _ENDS.get(percent, "stopped")
        return found

    def read_tilt(self, value: object) -> Readings:
        number = number_of(value)
        scale = self.steps.tilt
        if number is None or not min(scale.zero, scale.full) <= round(number) <= max(scale.zero, scale.full):
            return NO_READINGS
        return {"tilt": scale.percent(round(number))}


def _mover(config: DiscoveryConfig, command: CommandTopic | None) -> Writer | None:
    payloads = {
        movement: payload
        for movement, (key, default) in _COMMANDS.items()
        if (payload := config.payload(key, default)) is not None
    }
    if command is None or not payloads:
        return None
    return option_writer("movement", payloads, lambda movement: command.publish(payloads[movement]))


def _setter(name: str, command: CommandTopic | None, scale: Scale, variables: Mapping[str, object]) -> Writer | None:
    """Return the writer of a percentage, which is also a variable of the template."""
    if command is None:
        return None
    seen_as = "tilt_position" if name == "tilt" else name

    def publish(number: float) -> Publications:
        percent = round(number)
        return command.publish(round(scale.value(percent)), {seen_as: percent, **variables})

    return number_writer(name, (0, 100), "%", publish)
