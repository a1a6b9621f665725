"""The parts of a Tasmota device: lamps, relays, shutters, a fan, inputs and sensors. Pure.

Source: tasmota.github.io/docs, Commands > FanSpeed, and Blinds and Shutters; hatasmota 0.10.2, ``discovery.py``,
``fan.py`` and ``shutter.py``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

from homebot.conventions.command_values import bool_writer, require_bool, require_number, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.part_builder import JsonPart, with_own_ids
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.conventions.tasmota.config import (
    LIGHT,
    RELAY,
    SHUTTER,
    TasmotaConfig,
    Tilt,
    power_commands,
    sensor_values,
)
from homebot.conventions.tasmota.inputs import describe_inputs
from homebot.conventions.tasmota.light import add_light
from homebot.conventions.tasmota.sensors import Leaf, describe_sensors
from homebot.devices.value import PlainValue
from homebot.support.numbers import finite_number

__all__ = ["build_parts", "count_shutters"]


def _add_fan(part: JsonPart, config: TasmotaConfig) -> None:
    fan = _Fan(config)
    for topic in config.states(_COMMAND):
        part.read_from(topic, fan.read)
    part.add_capability("on_off", writer=fan.switch)
    part.add_capability("fan_speed", writer=fan.set_speed)
    part.add_command_topics(config.topic(_COMMAND))
    part.add_state_request(*config.state_requests)


_COMMAND = "FanSpeed"
_PERCENTS = (0.0, 33.0, 66.0, 100.0)
"""The largest percentage of each speed."""

_MIDDLE = 2


class _Fan:
    """Reader and writers of a fan. Switched on, it gets its last reported speed, for which it has no command."""

    __slots__ = ("_config", "_speed")

    def __init__(self, config: TasmotaConfig) -> None:
        self._config = config
        self._speed = _MIDDLE

    def read(self, message: JsonMessage) -> Readings:
        speed = message.get(_COMMAND)
        if type(speed) is not int or not 0 <= speed < len(_PERCENTS):
            return NO_READINGS
        self._speed = speed or self._speed
        return {"on_off": speed > 0, "fan_speed": _PERCENTS[speed]}

    def switch(self, value: PlainValue, _transition: float) -> Publications:
        return self._config.publish(_COMMAND, self._speed if require_bool("on_off", value) else 0)

    def set_speed(self, value: PlainValue, _transition: float) -> Publications:
        percent = require_number("fan_speed", value, 0, 100, "%")
        return self._config.publish(_COMMAND, next(speed for speed, most in enumerate(_PERCENTS) if percent <= most))


def count_shutters(outputs: tuple[int, ...]) -> int:
    """Return the number of shutters, each of two adjacent outputs; 0 if one has no partner."""
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


def _add_shutter(part: JsonPart, config: TasmotaConfig, index: int) -> tuple[object, ...]:
    """Add the capabilities of the shutter *index*; return the options from which the payloads of commands follow."""
    options = config.shutter_options[index] if index < len(config.shutter_options) else 0
    tilt = config.tilts[index] if index < len(config.tilts) else None
    shutter = _Shutter(config, index + 1, bool(options & _INVERTED), tilt)
    for topic in (*config.results("Shutter"), *config.sensors):
        part.read_from(topic, shutter.read)
    part.add_capability("movement", writer=shutter.move)
    part.add_capability("position", writer=shutter.set_position)
    if tilt is not None:
        part.add_capability("tilt", writer=shutter.set_tilt)
    part.add_command_topics(*(config.topic(f"Shutter{name}{index + 1}") for name in (*_COMMANDS.values(), "Position")))
    if tilt is not None:
        part.add_command_topics(config.topic(f"ShutterTilt{index + 1}"))
    part.add_state_request(*config.sensor_requests)
    return shutter.is_inverted, shutter.tilt


_INVERTED = 1
_COMMANDS = {"open": "Open", "closed": "Close", "stopped": "Stop"}


@dataclass(frozen=True, slots=True)
class _Shutter:
    """Reader and writers of one shutter; they are numbered from 1."""

    config: TasmotaConfig
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

    def move(self, value: PlainValue, _transition: float) -> Publications:
        return self.config.publish(f"Shutter{_COMMANDS[require_option('movement', value, _COMMANDS)]}{self.number}")

    def set_position(self, value: PlainValue, _transition: float) -> Publications:
        percent = round(require_number("position", value, 0, 100, "%"))
        return self.config.publish(f"ShutterPosition{self.number}", 100 - percent if self.is_inverted else percent)

    def set_tilt(self, value: PlainValue, _transition: float) -> Publications:
        percent = require_number("tilt", value, 0, 100, "%")
        tilt = self.tilt or Tilt(0, 100)
        return self.config.publish(
            f"ShutterTilt{self.number}", round(tilt.least + percent * (tilt.most - tilt.least) / 100)
        )

    @staticmethod
    def _movement(direction: int, position: float | None) -> str:
        if direction:
            return "opening" if direction > 0 else "closing"
        if position is None:
            return "stopped"
        return "open" if position else "closed"


def build_parts(config: TasmotaConfig, leaves: Iterable[Leaf]) -> tuple[DescribedPart, ...]:
    """Describe the parts of a device, with unique ids.

    The first relay of an iFan is its lamp. The others make the speeds of its fan: they are reported and, unlike in Home
    Assistant, cannot be switched alone.
    """
    described = chain(_outputs(config), describe_inputs(config), describe_sensors(config, leaves))
    return with_own_ids(described, _MOST_PARTS)


_MOST_PARTS = 500

_LAMPS_OPTION = 30
"""SetOption30: the relays switch lamps."""


def _outputs(config: TasmotaConfig) -> Iterable[DescribedPart]:
    for index, output in enumerate(config.outputs):
        name = config.output_name(index)
        if config.is_fan and output in (RELAY, LIGHT):
            yield _relay(config, index, "light", name) if index == 0 else _relay_of_fan(config, index, name)
        elif output == LIGHT:
            part = JsonPart(f"light_{index + 1}", "light", name=name, advertised="light")
            add_light(part, config, index)
            yield part.build()
        elif output == RELAY:
            yield _relay(config, index, "light" if config.option(_LAMPS_OPTION) else "switch", name)
    for index in range(count_shutters(config.outputs)):
        part = JsonPart(f"shutter_{index + 1}", "window_covering", advertised="shutter", tag="shutter")
        yield part.build(_add_shutter(part, config, index))
    if config.is_fan:
        part = JsonPart("fan", "fan", advertised="fan")
        _add_fan(part, config)
        yield part.build()


def _relay(config: TasmotaConfig, index: int, service_type: str, name: str) -> DescribedPart:
    part = JsonPart(f"power_{index + 1}", service_type, name=name, advertised="relay")
    _add_power(part, config, index, "on_off")
    command = f"Power{index + 1}"
    part.add_command_topics(config.topic(command))
    switch = bool_writer("on_off", lambda on: config.publish(command, config.state_text(on)))
    part.add_capability("on_off", writer=switch)
    return part.build()


def _relay_of_fan(config: TasmotaConfig, index: int, name: str) -> DescribedPart:
    part = JsonPart(f"power_{index + 1}", "x_binary_sensor", name=name, advertised="relay", category="diagnostic")
    _add_power(part, config, index, "state")
    part.add_capability("state")
    return part.build()


def _add_power(part: JsonPart, config: TasmotaConfig, index: int, capability: str) -> None:
    def read(message: JsonMessage) -> Readings:
        is_on = config.read_power(index, message)
        return NO_READINGS if is_on is None else {capability: is_on}

    for topic in config.states(*power_commands(index)):
        part.read_from(topic, read)
    part.add_state_request(*config.state_requests)
