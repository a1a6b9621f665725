"""Covers, locks, fans and sirens that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > cover, lock and fan; zigbee-herdsman-converters 26.105.0, ``warning``;
percentages as Zigbee2MQTT 2.14.1 announces them to Home Assistant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.conventions.zigbee2mqtt.features import Zigbee2MqttTopics, add_enum, add_flag, add_reader, same_scalar
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = [
    "FEATURES_OF_COVER",
    "FEATURES_OF_FAN",
    "FEATURES_OF_LOCK",
    "build_cover",
    "build_fan",
    "build_lock",
    "build_siren",
]


FEATURES_OF_COVER = frozenset({"state", "position", "tilt"})


def build_cover(part: JsonPart, topics: Zigbee2MqttTopics, cover: Expose, motor: Expose | None) -> DescribedPart:
    """Describe a cover.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        cover: What it exposes.
        motor: The enum that reports how its motor turns; None where it has none.
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
"""Words for a motor that turns; when it stands, the state has the end."""


def _percent(value: object) -> float | None:
    number = finite_number(value)
    return None if number is None else min(100.0, max(0.0, number))


def _move(topics: Zigbee2MqttTopics, key: str, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
    return topics.publish({key: _COMMANDS[require_option("movement", value, _COMMANDS)]})


def _set(
    topics: Zigbee2MqttTopics, key: str, name: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    return topics.publish({key: round(require_number(name, value, 0, 100, "%"))})


FEATURES_OF_LOCK = frozenset({"state", "lock_state"})


def build_lock(part: JsonPart, topics: Zigbee2MqttTopics, lock: Expose) -> DescribedPart:
    """Describe a lock. A bolt that is not fully out counts as unlocked, which is the careful reading."""
    state, bolt = lock.feature("state"), lock.feature("lock_state")
    part.read_from(topics.state, partial(_read, state, bolt))
    writer = partial(_write, topics, state) if state is not None and state.is_settable else None
    is_readable = any(one is not None and one.is_published for one in (state, bolt))
    part.add_capability("lock", readable=is_readable, writer=writer, options=("locked", "unlocked"))
    part.add_command_topics(topics.command)
    part.add_state_request(*topics.request_state(state))
    return part.build()


_BOLTS: Mapping[str, str] = {"locked": "locked", "unlocked": "unlocked", "not_fully_locked": "unlocked"}


def _read(state: Expose | None, bolt: Expose | None, message: JsonMessage) -> Readings:
    if state is not None and state.key in message:
        value = message[state.key]
        if value is None:
            return {"lock": None}
        for position, expected in (("locked", state.value_on), ("unlocked", state.value_off)):
            if same_scalar(value, expected):
                return {"lock": position}
        return NO_READINGS
    bolt_state = message.get(bolt.key) if bolt is not None else None
    return {"lock": _BOLTS[bolt_state]} if isinstance(bolt_state, str) and bolt_state in _BOLTS else NO_READINGS


def _write(topics: Zigbee2MqttTopics, state: Expose, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
    target = require_option("lock", value, ("locked", "unlocked"))
    return topics.publish({state.key: state.value_on if target == "locked" else state.value_off})


FEATURES_OF_FAN = frozenset({"state", "mode", "speed"})


def build_fan(part: JsonPart, topics: Zigbee2MqttTopics, fan: Expose, model: str) -> DescribedPart:
    """Describe a fan.

    Args:
        part: The part in the making.
        topics: The topics of its device.
        fan: What it exposes.
        model: Which model it is: one of them spells its fastest speed differently.
    """
    state, mode, speed = (fan.feature(name) for name in ("state", "mode", "speed"))
    add_flag(part, topics, state, "on_off")
    if mode is not None:
        add_enum(part, topics, mode, "fan_mode")
        _add_speed_steps(part, topics, mode, _speed_steps(mode, model))
    elif speed is not None:
        _add_speed_range(part, topics, speed)
    part.add_state_request(*topics.request_state(state, mode, speed))
    return part.build()


_SPEEDS = ("low", "medium", "high", "1", "2", "3", "4", "5", "6", "7", "8", "9")
_MODELS_WHOSE_ON_IS_FASTEST = frozenset({"99432"})


def _speed_steps(mode: Expose, model: str) -> tuple[str, ...]:
    """From off to the fastest."""
    fastest = ("on",) if model in _MODELS_WHOSE_ON_IS_FASTEST else ()
    return "off", *(speed for speed in (*_SPEEDS, *fastest) if speed in mode.options)


def _add_speed_steps(part: JsonPart, topics: Zigbee2MqttTopics, mode: Expose, speeds: Sequence[str]) -> None:
    if len(speeds) == 1:
        return
    if mode.is_published:
        add_reader(part, topics, mode, "fan_speed", partial(_percent_of_speed, speeds))
    writer = partial(_write_speed, topics, mode.key, speeds) if mode.is_settable else None
    part.add_capability("fan_speed", readable=mode.is_published, writer=writer)


def _add_speed_range(part: JsonPart, topics: Zigbee2MqttTopics, speed: Expose) -> None:
    least, most = speed.least, speed.most
    if least is None or most is None or least >= most:
        return
    if speed.is_published:
        add_reader(part, topics, speed, "fan_speed", partial(_percent_of_step, least, most))
    writer = partial(_write_step, topics, speed.key, least, most) if speed.is_settable else None
    part.add_capability("fan_speed", readable=speed.is_published, writer=writer)


def _percent_of_speed(speeds: Sequence[str], value: object) -> float | None:
    known = isinstance(value, str) and value in speeds
    return float(speeds.index(str(value)) * 100 // (len(speeds) - 1)) if known else None


def _write_speed(
    topics: Zigbee2MqttTopics, key: str, speeds: Sequence[str], value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    percent = require_number("fan_speed", value, 0, 100, "%")
    return topics.publish({key: speeds[math.ceil(percent * (len(speeds) - 1) / 100)]})


def _percent_of_step(least: float, most: float, value: object) -> float | None:
    number = finite_number(value)
    if number is None:
        return None
    return min(100.0, max(0.0, (number - least + 1) * 100 / (most - least + 1)))


def _write_step(
    topics: Zigbee2MqttTopics, key: str, least: float, most: float, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    percent = require_number("fan_speed", value, 0, 100, "%")
    return topics.publish({key: math.ceil(percent * (most - least + 1) / 100 + least - 1) if percent else 0})


def build_siren(part: JsonPart, topics: Zigbee2MqttTopics, warning: Expose) -> DescribedPart:
    """Describe a siren."""
    mode = warning.feature("mode")
    tones = tuple(one for one in mode.options if one != _SILENT) if mode is not None else ()
    siren = _Siren(topics, warning.key, tones)
    part.add_capability("on_off", readable=False, writer=siren.switch)
    if tones:
        part.add_capability("siren_tone", readable=False, writer=siren.sound, options=tones)
    if warning.feature("level") is not None:
        part.add_capability("volume", readable=False, writer=siren.set_volume)
    part.add_command_topics(topics.command)
    return part.build()


_SILENT = "stop"
_TONE = "emergency"
_SECONDS = 10
_LEVELS = ((25.0, "low"), (50.0, "medium"), (75.0, "high"), (100.0, "very_high"))


@dataclass(frozen=True, slots=True)
class _Siren:
    """The commands of a siren. Tone and volume also turn it on."""

    topics: Zigbee2MqttTopics
    key: str
    tones: tuple[str, ...]

    def switch(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if require_bool("on_off", value):
            return self._warn()
        return self.topics.publish({self.key: {"mode": _SILENT}})

    def sound(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._warn(tone=require_option("siren_tone", value, self.tones))

    def set_volume(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = require_number("volume", value, 0, 100, "%")
        return self._warn(level=next(level for most, level in _LEVELS if percent <= most))

    def _warn(self, *, tone: str = "", level: str = "medium") -> tuple[Publication, ...]:
        usual = _TONE if _TONE in self.tones or not self.tones else self.tones[0]
        return self.topics.publish({self.key: {"mode": tone or usual, "level": level, "duration": _SECONDS}})
