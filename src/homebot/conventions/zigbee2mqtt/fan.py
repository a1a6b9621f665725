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
from homebot.conventions.zigbee2mqtt.features import hear, offer_enum, offer_flag
from homebot.devices.value import PlainValue
from homebot.numbers import finite_number

__all__ = ["FEATURES_OF_FAN", "build_fan"]

FEATURES_OF_FAN = frozenset({"state", "mode", "speed"})


def build_fan(part: JsonPart, lines: Zigbee2MqttTopics, fan: Expose, model: str) -> DescribedPart:
    """Describe a fan.

    Args:
        part: The part in the making.
        lines: Where its device speaks and listens.
        fan: What it exposes.
        model: Which model it is: one of them spells its fastest speed differently.
    """
    state, mode, speed = (fan.feature(name) for name in ("state", "mode", "speed"))
    offer_flag(part, lines, state, "on_off")
    if mode is not None:
        offer_enum(part, lines, mode, "fan_mode")
        _offer_words(part, lines, mode, _words(mode, model))
    elif speed is not None:
        _offer_range(part, lines, speed)
    part.add_state_request(*lines.ask(state, mode, speed))
    return part.build()


_SPEEDS = ("low", "medium", "high", "1", "2", "3", "4", "5", "6", "7", "8", "9")
_MODELS_WHOSE_ON_IS_FASTEST = frozenset({"99432"})


def _words(mode: Expose, model: str) -> tuple[str, ...]:
    """From off to the fastest."""
    fastest = ("on",) if model in _MODELS_WHOSE_ON_IS_FASTEST else ()
    return "off", *(word for word in (*_SPEEDS, *fastest) if word in mode.options)


def _offer_words(part: JsonPart, lines: Zigbee2MqttTopics, mode: Expose, words: Sequence[str]) -> None:
    if len(words) == 1:
        return
    if mode.is_said:
        hear(part, lines, mode, "fan_speed", partial(_percent_of_word, words))
    writer = partial(_write_word, lines, mode.key, words) if mode.is_settable else None
    part.add_capability("fan_speed", readable=mode.is_said, writer=writer)


def _offer_range(part: JsonPart, lines: Zigbee2MqttTopics, speed: Expose) -> None:
    least, most = speed.least, speed.most
    if least is None or most is None or least >= most:
        return
    if speed.is_said:
        hear(part, lines, speed, "fan_speed", partial(_percent_of_step, least, most))
    writer = partial(_write_step, lines, speed.key, least, most) if speed.is_settable else None
    part.add_capability("fan_speed", readable=speed.is_said, writer=writer)


def _percent_of_word(words: Sequence[str], value: object) -> float | None:
    known = isinstance(value, str) and value in words
    return float(words.index(str(value)) * 100 // (len(words) - 1)) if known else None


def _write_word(
    lines: Zigbee2MqttTopics, key: str, words: Sequence[str], value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    percent = require_number("fan_speed", value, 0, 100, "%")
    return lines.tell({key: words[math.ceil(percent * (len(words) - 1) / 100)]})


def _percent_of_step(least: float, most: float, value: object) -> float | None:
    number = finite_number(value)
    if number is None:
        return None
    return min(100.0, max(0.0, (number - least + 1) * 100 / (most - least + 1)))


def _write_step(
    lines: Zigbee2MqttTopics, key: str, least: float, most: float, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    percent = require_number("fan_speed", value, 0, 100, "%")
    return lines.tell({key: math.ceil(percent * (most - least + 1) / 100 + least - 1) if percent else 0})
