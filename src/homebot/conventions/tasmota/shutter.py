"""Shutters with Tasmota firmware. Pure.

Source: tasmota.github.io/docs, Blinds and Shutters; hatasmota 0.10.2, ``shutter.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.tasmota.config import SHUTTER, Tilt
from homebot.conventions.tasmota.device_topics import TasmotaTopics, sensor_values
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = ["add_shutter", "count_shutters"]


def count_shutters(outputs: tuple[int, ...]) -> int:
    """Return how many shutters there are: each has two outputs, one after the other. None where one has no partner."""
    pairs, index = 0, 0
    while index < len(outputs):
        if outputs[index] != SHUTTER:
            index += 1
            continue
        if outputs[index : index + 2] != (SHUTTER, SHUTTER):
            return 0
        pairs += 1
        index += 2
    return pairs


def add_shutter(part: JsonPart, topics: TasmotaTopics, index: int) -> None:
    """Have *part* be the shutter *index*."""
    config = topics.config
    options = config.shutter_options[index] if index < len(config.shutter_options) else 0
    tilt = config.tilts[index] if index < len(config.tilts) else None
    shutter = _Shutter(topics, index + 1, bool(options & _INVERTED), tilt)
    for topic in (topics.states[0], *topics.sensors):
        part.read_from(topic, shutter.read)
    part.add_capability("movement", writer=shutter.move)
    part.add_capability("position", writer=shutter.set_position)
    if tilt is not None:
        part.add_capability("tilt", writer=shutter.set_tilt)
    part.add_command_topics(*(topics.topic(f"Shutter{name}{index + 1}") for name in (*_COMMANDS.values(), "Position")))
    if tilt is not None:
        part.add_command_topics(topics.topic(f"ShutterTilt{index + 1}"))
    part.add_state_request(*topics.sensor_requests)


_INVERTED = 1
_COMMANDS = {"open": "Open", "closed": "Close", "stopped": "Stop"}


@dataclass(frozen=True, slots=True)
class _Shutter:
    """The state and the commands of one shutter.

    Attributes:
        topics: Its topics.
        number: Which it is, from 1.
        is_inverted: Whether its positions are turned round.
        tilt: How its slats turn; None where they do not.
    """

    topics: TasmotaTopics
    number: int
    is_inverted: bool
    tilt: Tilt | None

    def read(self, message: JsonMessage) -> Readings:
        fields = sensor_values(message).get(f"Shutter{self.number}")
        if not isinstance(fields, dict):
            return NO_READINGS
        found: dict[str, PlainValue] = {}
        position = finite_number(fields.get("Position"))
        if position is not None and 0 <= position <= 100:
            position = 100 - position if self.is_inverted else position
            found["position"] = position
        direction = fields.get("Direction")
        if isinstance(direction, int) and direction in (-1, 0, 1):
            found["movement"] = self._movement(-direction if self.is_inverted else direction, position)
        angle = finite_number(fields.get("Tilt"))
        if self.tilt is not None and angle is not None:
            percent = (angle - self.tilt.least) * 100 / (self.tilt.most - self.tilt.least)
            found["tilt"] = min(100.0, max(0.0, percent))
        return found

    def move(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self.topics.publish(f"Shutter{_COMMANDS[require_option('movement', value, _COMMANDS)]}{self.number}")

    def set_position(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = round(require_number("position", value, 0, 100, "%"))
        return self.topics.publish(f"ShutterPosition{self.number}", 100 - percent if self.is_inverted else percent)

    def set_tilt(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = require_number("tilt", value, 0, 100, "%")
        tilt = self.tilt or Tilt(0, 100)
        return self.topics.publish(
            f"ShutterTilt{self.number}", round(tilt.least + percent * (tilt.most - tilt.least) / 100)
        )

    @staticmethod
    def _movement(direction: int, position: float | None) -> str:
        if direction:
            return "opening" if direction > 0 else "closing"
        if position is None:
            return "stopped"
        return "open" if position else "closed"
