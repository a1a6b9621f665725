"""Blinds, shutters and curtains that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > cover. 100 is open, unless the user turned it round in Zigbee2MQTT, which
then turns what it says and what it takes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.conventions.zigbee2mqtt.features import add_reader
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = ["FEATURES_OF_COVER", "build_cover"]

FEATURES_OF_COVER = frozenset({"state", "position", "tilt"})


def build_cover(part: JsonPart, topics: Zigbee2MqttTopics, cover: Expose, motor: Expose | None) -> DescribedPart:
    """Describe a cover.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        cover: What it exposes.
        motor: The enum that tells how its motor turns; None where it has none.
    """
    state, position, tilt = (cover.feature(name) for name in ("state", "position", "tilt"))
    part.add_command_topics(topics.command)
    if state is not None:
        part.read_from(topics.state, _Movement(state.key, position.key if position else "", motor).read)
        writer = partial(_move, topics, state.key) if state.is_settable else None
        part.add_capability("movement", readable=state.is_published, writer=writer)
    for name, feature in (("position", position), ("tilt", tilt)):
        if feature is not None:
            add_reader(part, topics, feature, name, _percent)
            mover = partial(_set, topics, feature.key, name) if feature.is_settable else None
            part.add_capability(name, readable=feature.is_published, writer=mover)
    part.add_state_request(*topics.request_state(state, position, tilt))
    return part.build()


@dataclass(frozen=True, slots=True)
class _Movement:
    """Reads where the cover is or goes.

    A motor's word is often left standing when the cover has arrived, so an end that state and position agree on counts
    before it.
    """

    state: str
    position: str
    motor: Expose | None

    def read(self, message: JsonMessage) -> Readings:
        if self.state not in message:
            return NO_READINGS
        state = message[self.state]
        if state is None:
            return {"movement": None}
        at = _STATES.get(state) if isinstance(state, str) else None
        turns = message.get(self.motor.key) if self.motor is not None else None
        direction = _DIRECTIONS.get(turns.lower()) if isinstance(turns, str) else None
        if direction is None or (self.position and message.get(self.position) == _ENDS.get(at or "")):
            return NO_READINGS if at is None else {"movement": at}
        return {"movement": direction}


_STATES: Mapping[str, str] = {"OPEN": "open", "CLOSE": "closed", "STOP": "stopped"}
_COMMANDS: Mapping[str, str] = {"open": "OPEN", "closed": "CLOSE", "stopped": "STOP"}
_ENDS: Mapping[str, int] = {"open": 100, "closed": 0}
_DIRECTIONS: Mapping[str, str] = {
    **dict.fromkeys(("opening", "open", "forward", "up", "rising"), "opening"),
    **dict.fromkeys(("closing", "close", "backward", "back", "reverse", "down", "declining"), "closing"),
}
"""Words for a motor that turns; when it stands, the state tells where."""


def _percent(value: object) -> float | None:
    number = finite_number(value)
    return None if number is None else min(100.0, max(0.0, number))


def _move(topics: Zigbee2MqttTopics, key: str, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
    return topics.publish({key: _COMMANDS[require_option("movement", value, _COMMANDS)]})


def _set(
    topics: Zigbee2MqttTopics, key: str, name: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    return topics.publish({key: round(require_number(name, value, 0, 100, "%"))})
