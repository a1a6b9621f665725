"""Reader of Tasmota's announcements, two messages of a device, and the parts that follow from them. Pure.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; tasmota.github.io/docs, Commands > FanSpeed, Blinds and
Shutters, Buttons and Switches; hatasmota 0.10.2, ``discovery.py``, ``fan.py``, ``shutter.py``, ``switch.py`` and
``button.py``.
"""

import re
from collections.abc import Iterable, Mapping
from functools import partial
from itertools import chain
from typing import NamedTuple

from homebot.conventions.command_values import bool_writer, option_writer, percent_writer, speed_of
from homebot.conventions.description import (
    AnnouncementEvent,
    AutoExpiry,
    Availability,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    LastWillAvailability,
    Publications,
)
from homebot.conventions.part_builder import JsonPart, with_own_ids
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, as_fields, clean_text, parse_object
from homebot.conventions.units import percent_grid
from homebot.devices.identity import identifiers, in_pairs
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.tasmota.formats.config import (
    LIGHT,
    RELAY,
    SHUTTER,
    STATE_TEXTS,
    TasmotaConfig,
    Tilt,
    power_commands,
    read_config,
    sensor_values,
)
from homebot.integrations.tasmota.formats.light import add_light
from homebot.integrations.tasmota.formats.sensors import Leaf, describe_sensors, read_leaves
from homebot.support.bounded_map import BoundedMap
from homebot.support.numbers import finite_number

_COMMAND = "FanSpeed"
_MIDDLE = 2
_PERCENTS = (0.0, 33.0, 66.0, 100.0)
"""The largest percentage of each speed."""


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
    part.add_capability("position", writer=percent_writer("position", set_position))
    part.add_command_topics(*(config.topic(f"Shutter{name}{number}") for name in (*_COMMANDS.values(), "Position")))
    if tilt is not None:
        command, way = f"ShutterTilt{number}", tilt.most - tilt.least
        writer = percent_writer(
            "tilt", lambda percent: config.publish(command, round(tilt.least + percent * way / 100))
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
    readings: dict[str, PlainValue] = {}
    position = finite_number(fields.get("Position"))
    if position is not None and 0 <= position <= 100:
        position = 100 - position if is_inverted else position
        readings["position"] = position
    direction = fields.get("Direction")
    if isinstance(direction, int) and direction in (-1, 0, 1):
        way = -direction if is_inverted else direction
        if way:
            readings["movement"] = "opening" if way > 0 else "closing"
        elif position is None:
            readings["movement"] = "stopped"
        else:
            readings["movement"] = "open" if position else "closed"
    angle = finite_number(fields.get("Tilt"))
    if tilt is not None and angle is not None:
        percent = (angle - tilt.least) * 100 / (tilt.most - tilt.least)
        readings["tilt"] = min(100.0, max(0.0, percent))
    return readings


def build_parts(config: TasmotaConfig, leaves: Iterable[Leaf]) -> tuple[DescribedPart, ...]:
    """Describe the parts of a device, with unique ids.

    The first relay of an iFan is its lamp. The others make the speeds of its fan: they are reported and, unlike in Home
    Assistant, cannot be switched alone.
    """
    described = chain(_outputs(config), _inputs(config), describe_sensors(config, leaves))
    return with_own_ids(described, _MAX_PARTS)


_MAX_PARTS = 500

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
        part = JsonPart("fan", "fan", commands=config.topic(_COMMAND), advertised="fan")
        last = _MIDDLE

        def read(message: JsonMessage) -> Readings:
            nonlocal last
            speed = message.get(_COMMAND)
            if type(speed) is not int or not 0 <= speed < len(_PERCENTS):
                return NO_READINGS
            last = speed or last
            return {"on_off": speed > 0, "fan_speed": _PERCENTS[speed]}

        def set_speed(percent: float) -> Publications:
            return config.publish(_COMMAND, speed_of(percent, len(_PERCENTS) - 1))

        for topic in config.states(_COMMAND):
            part.read_from(topic, read)
        part.add_capability(
            "on_off", writer=bool_writer("on_off", lambda on: config.publish(_COMMAND, last if on else 0))
        )
        grid = percent_grid(len(_PERCENTS) - 1)
        part.add_capability("fan_speed", writer=percent_writer("fan_speed", set_speed), grid=grid)
        part.add_state_request(*config.state_requests)
        yield part.build()


def _relay(config: TasmotaConfig, index: int, service_type: str, name: str) -> DescribedPart:
    command = f"Power{index + 1}"
    part = JsonPart(f"power_{index + 1}", service_type, commands=config.topic(command), name=name, advertised="relay")
    _add_power(part, config, index, "on_off")
    switch = bool_writer("on_off", lambda on: config.publish(command, config.state_text(on)))
    part.add_capability("on_off", writer=switch)
    return part.build(None if config.state_texts[:2] == STATE_TEXTS[:2] else config.state_texts[:2])


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


def _inputs(config: TasmotaConfig) -> Iterable[DescribedPart]:
    """Describe the contacts, and the presses of switches and buttons."""
    for index, mode in enumerate(config.switch_modes):
        if mode in _FOLLOWED:
            name = _switch_name(config, index)
            part = JsonPart(f"switch_{index + 1}", "x_binary_sensor", name=clean_text(name), advertised="switch")
            read = partial(_read_state, config.state_texts[0], config.state_texts[1], name)
            part.add_capability("state")
            if mode in _PULSES:
                for topic in config.results(f"Switch{index + 1}"):
                    part.read_events_from(topic, read)
                part.add_expiry(AutoExpiry("state", _PULSE_SECONDS, value=False, only=True))
            else:
                for topic in (*config.results(f"Switch{index + 1}"), *config.sensors):
                    part.read_from(topic, read)
                part.add_state_request(*config.sensor_requests)
            yield part.build()
        if mode in _PRESSED:
            actions = {config.state_texts[place]: press for place, press in _PRESSED[mode].items()}
            name = _switch_name(config, index)
            yield _presses(config, f"switch_{index + 1}_press", f"Switch{index + 1}", name, actions)
    if config.option(_BUTTONS_OPTION):
        for index, is_there in enumerate(config.buttons):
            if is_there:
                report = f"Button{index + 1}"
                yield _presses(config, f"button_{index + 1}", report, report, _button_actions(config))


_TOGGLE, _HOLD = 2, 3
"""Places in a device's texts of states."""

_PULSES = frozenset({13, 14})
"""Modes of inputs that report on and never off."""

_FOLLOWED = frozenset({1, 2, 3, 4, 5, 6, 9, 10, 13, 14, 15, 16})
"""Modes in which the input's state is reported."""

_SINGLE = {_TOGGLE: "single"}
_PRESSED: Mapping[int, Mapping[int, str]] = {
    0: _SINGLE,
    3: _SINGLE,
    4: _SINGLE,
    5: {_TOGGLE: "single", _HOLD: "hold"},
    6: {_TOGGLE: "single", _HOLD: "hold"},
    7: _SINGLE,
    8: {_TOGGLE: "single", _HOLD: "double"},
    9: {_HOLD: "double"},
    10: {_HOLD: "double"},
    11: _SINGLE,
    12: _SINGLE,
}
"""Modes that report presses, with the meaning of each text."""

_BUTTONS_OPTION, _SWAP_OPTION, _SINGLE_ONLY_OPTION = 73, 11, 13
_BUTTON_ACTIONS: Mapping[str, str] = {
    "SINGLE": "single",
    "DOUBLE": "double",
    "TRIPLE": "triple",
    "QUAD": "quadruple",
    "PENTA": "quintuple",
    "HOLD": "hold",
}
_PULSE_SECONDS = 1.0


def _switch_name(config: TasmotaConfig, index: int) -> str:
    names = config.switch_names
    return (names[index] if index < len(names) else "") or f"Switch{index + 1}"


def _read_state(off: str, on: str, name: str, message: JsonMessage) -> Readings:
    """Read the action on one topic, the bare text on the others."""
    value = sensor_values(message).get(name)
    text = value.get("Action") if isinstance(value, dict) else value
    if not isinstance(text, str) or text not in (off, on):
        return NO_READINGS
    return {"state": text == on}


def _button_actions(config: TasmotaConfig) -> Mapping[str, str]:
    if config.option(_SINGLE_ONLY_OPTION):
        return {"SINGLE": "single"}
    if config.option(_SWAP_OPTION):
        return {**_BUTTON_ACTIONS, "SINGLE": "double", "DOUBLE": "single"}
    return _BUTTON_ACTIONS


def _presses(config: TasmotaConfig, part_id: str, report: str, name: str, actions: Mapping[str, str]) -> DescribedPart:
    part = JsonPart(part_id, "generic_switch", name=clean_text(name), advertised="button")
    for topic in config.results(report):
        part.read_events_from(topic, partial(_read_press, name, actions))
    part.add_capability("press", options=tuple(dict.fromkeys(actions.values())))
    return part.build()


def _read_press(name: str, actions: Mapping[str, str], message: JsonMessage) -> Readings:
    action = as_fields(message.get(name)).get("Action")
    return {"press": actions[action]} if isinstance(action, str) and action in actions else NO_READINGS


MAX_DEVICES = 5_000
"""Most devices; the announcement of one more is refused."""

MAX_WAITING = 1_000
"""Most devices with ``sensors`` and without ``config``; the oldest is dropped and counted."""


class _KnownTasmota(NamedTuple):
    config: TasmotaConfig
    leaves: tuple[Leaf, ...]
    device: DeviceAnnounced


class TasmotaReader:
    """Reader of both messages of each device.

    A device is :class:`DeviceAnnounced` with its ``config``, and again with its ``sensors``, which wait for the
    ``config``. An unchanged ``config`` gives the same description, with the same codecs and their last values. At most
    :data:`MAX_DEVICES` are stored, and at most :data:`MAX_WAITING` wait.

    Attributes:
        forgotten: Number of dropped devices without ``config``.
    """

    def __init__(self, prefix: str) -> None:
        self.rejected = 0
        self.forgotten = 0
        self._prefix = prefix
        self._waiting: BoundedMap[str, tuple[Leaf, ...]] = BoundedMap(MAX_WAITING)
        self._known: dict[str, _KnownTasmota] = {}
        self._probes: BoundedMap[str, dict[str, str]] = BoundedMap(MAX_DEVICES)

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - announcements are retained
        """Return the description of a device; nothing before its ``config``."""
        match = _TOPIC.fullmatch(topic.removeprefix(f"{self._prefix}/"))
        if match is None or not topic.startswith(f"{self._prefix}/"):
            return ()
        mac, kind = match.groups()
        if kind == "config":
            known = self._known.get(mac)
            if not payload:
                self._known.pop(mac, None)
                return () if known is None else (DeviceWithdrawn(mac, "its config was removed"),)
            config = read_config(mac, payload)
            if known is not None:
                return (known.device,) if config == known.config else self._announce(mac, config, known.leaves)
            if len(self._known) >= MAX_DEVICES:
                raise WireError(f"{mac} exceeds the limit of {MAX_DEVICES} devices")
            return self._announce(mac, config, self._waiting.pop(mac, ()))
        self._probes[mac] = probes = self._probes.get(mac, {})
        leaves = read_leaves(parse_object(payload), probes) if payload else ()
        known = self._known.get(mac)
        if known is not None:
            return () if leaves == known.leaves else self._announce(mac, known.config, leaves)
        if len(self._waiting) == MAX_WAITING and mac not in self._waiting:
            self.forgotten += 1
        self._waiting[mac] = leaves
        return ()

    def _announce(self, mac: str, config: TasmotaConfig, leaves: tuple[Leaf, ...]) -> tuple[AnnouncementEvent, ...]:
        will = LastWillAvailability(f"{config.telemetry_base}LWT", config.online.encode(), config.offline.encode())
        device = DeviceAnnounced(
            key=mac,
            convention="tasmota",
            native=True,
            whole_device=True,
            identifiers=identifiers([in_pairs(mac)]),
            name=config.name,
            parts=build_parts(config, leaves),
            topic=f"{self._prefix}/{mac}/config",
            facts=config.facts,
            availability=None if config.is_sleeper else Availability((will,)),
            owns=config.own_topics,
        )
        self._known[mac] = _KnownTasmota(config, leaves, device)
        return (device,)


_TOPIC = re.compile("([0-9A-F]{12})/(config|sensors)")
