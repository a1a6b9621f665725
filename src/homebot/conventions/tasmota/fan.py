"""Ceiling fans with Tasmota firmware: Sonoff iFan02 to iFan04. Pure.

Source: tasmota.github.io/docs, Commands > FanSpeed; hatasmota 0.10.2, ``fan.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_bool, require_number
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.tasmota.device_topics import TasmotaTopics
from homebot.devices.value import PlainValue

__all__ = ["add_fan"]


def add_fan(part: JsonPart, topics: TasmotaTopics) -> None:
    """Have *part* be the fan."""
    fan = _Fan(topics)
    for topic in topics.states:
        part.read_from(topic, fan.read)
    part.add_capability("on_off", writer=fan.switch)
    part.add_capability("fan_speed", writer=fan.set_speed)
    part.add_command_topics(topics.topic(_COMMAND))
    part.add_state_request(*topics.state_requests)


_COMMAND = "FanSpeed"
_PERCENTS = (0.0, 33.0, 66.0, 100.0)
"""Of each speed: the largest percentage that it stands for."""

_MIDDLE = 2


class _Fan:
    """The state and the commands of a fan.

    It has no command for the speed from before, so the last one that it told is remembered.
    """

    __slots__ = ("_speed", "_topics")

    def __init__(self, topics: TasmotaTopics) -> None:
        self._topics = topics
        self._speed = _MIDDLE

    def read(self, message: JsonMessage) -> Readings:
        speed = message.get(_COMMAND)
        if type(speed) is not int or not 0 <= speed < len(_PERCENTS):
            return NO_READINGS
        self._speed = speed or self._speed
        return {"on_off": speed > 0, "fan_speed": _PERCENTS[speed]}

    def switch(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return self._topics.publish(_COMMAND, self._speed if require_bool("on_off", value) else 0)

    def set_speed(self, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        percent = require_number("fan_speed", value, 0, 100, "%")
        return self._topics.publish(_COMMAND, next(speed for speed, most in enumerate(_PERCENTS) if percent <= most))
