"""Fans that Zigbee2MQTT knows: with a speed of their own, or with words for a few speeds. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > fan; percentages as Zigbee2MQTT 2.14.1 announces them to Home Assistant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from homebot.conventions.command_values import require_number
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.conventions.zigbee2mqtt.features import add_enum, add_flag, add_reader
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = ["FEATURES_OF_FAN", "build_fan"]

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
