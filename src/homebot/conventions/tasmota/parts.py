"""The parts of a Tasmota device: lamps, relays, shutters, a fan, inputs and sensors. Pure.

Source: tasmota.github.io/docs, Commands > FanSpeed, and Blinds and Shutters; hatasmota 0.10.2, ``discovery.py``,
``fan.py`` and ``shutter.py``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import chain

from homebot.conventions.command_values import bool_writer, number_writer, option_writer
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


_COMMAND = "FanSpeed"
_MIDDLE = 2
_PERCENTS = (0.0, 33.0, 66.0, 100.0)
"""The largest percentage of each speed."""

_PERCENT = (0.0, 100.0)


def _add_fan(part: JsonPart, config: TasmotaConfig) -> None:
    """Add the capabilities of a fan. Switched on, it gets its last reported speed, for which it has no command."""
    last = _MIDDLE

    def read(message: JsonMessage) -> Readings:
        nonlocal last
        speed = message.get(_COMMAND)
        if type(speed) is not int or not 0 <= speed < len(_PERCENTS):
            return NO_READINGS
        last = speed or last
        return {"on_off": speed > 0, "fan_speed": _PERCENTS[speed]}

    def set_speed(percent: float) -> Publications:
        return config.publish(_COMMAND, next(speed for speed, most in enumerate(_PERCENTS) if percent <= most))

    for topic in config.states(_COMMAND):
        part.read_from(topic, read)
    part.add_capability("on_off", writer=bool_writer("on_off", lambda on: config.publish(_COMMAND, last if on else 0)))
    part.add_capability("fan_speed", writer=number_writer("fan_speed", _PERCENT, "%", set_speed))
    part.add_command_topics(config.topic(_COMMAND))
    part.add_state_request(*config.state_requests)


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
    is_inverted, number = bool(options & _INVERTED), index + 1

    def move(movement: str) -> Publications:
        return config.publish(f"Shutter{_COMMANDS[movement]}{number}")

    def set_position(percent: float) -> Publications:
        return config.publish(f"ShutterPosition{number}", 100 - round(percent) if is_inverted else round(percent))

    for topic in (*config.results("Shutter"), *config.sensors):
        part.read_from(topic, partial(_read_shutter, f"Shutter{number}", is_inverted, tilt))
    part.add_capability("movement", writer=option_writer("movement", _COMMANDS, move))
    part.add_capability("position", writer=number_writer("position", _PERCENT, "%", set_position))
    part.add_command_topics(*(config.topic(f"Shutter{name}{number}") for name in (*_COMMANDS.values(), "Position")))
    if tilt is not None:
        command, way = f"ShutterTilt{number}", tilt.most - tilt.least
        writer = number_writer(
            "tilt", _PERCENT, "%", lambda percent: config.publish(command, round(tilt.least + percent * way / 100))
        )
        part.add_capability("tilt", writer=writer)
        part.add_command_topics(config.topic(command))
    part.add_state_request(*config.sensor_requests)
    return is_inverted, tilt


_INVERTED = 1
_COMMANDS = {"open": "Open", "closed": "Close", "stopped": "Stop"}


def _read_shutter(name: str, is_inverted: bool, tilt: Tilt | None, message: JsonMessage) -> Readings:  # noqa: FBT001 - bound
    fields = sensor_values(message).get(name)
    if not isinstance(fields, dict):
        return NO_READINGS
    found: dict[str, PlainValue] = {}
    position = finite_number(fields.get("Position"))
    if position is not None and 0 <= position <= 100:
        position = 100 - position if is_inverted else position
        found["position"] = position
    direction = fields.get("Direction")
    if isinstance(direction, int) and direction in (-1, 0, 1):
        found["movement"] = _movement(-direction if is_inverted else direction, position)
    angle = finite_number(fields.get("Tilt"))
    if tilt is not None and angle is not None:
        percent = (angle - tilt.least) * 100 / (tilt.most - tilt.least)
        found["tilt"] = min(100.0, max(0.0, percent))
    return found


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
