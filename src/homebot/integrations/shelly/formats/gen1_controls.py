"""Relays, rollers, valves, inputs and lamps of Shelly's first generation. Pure.

Source: Shelly Gen1 API, MQTT of Shelly1, Shelly2.5, Plug, Gas, Dimmer, Duo, Bulb and RGBW2, and of ``input/<i>`` and
``input_event/<i>``; ``transition`` is in milliseconds.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import bool_writer, option_writer, percent_writer
from homebot.conventions.description import Publication, Publications
from homebot.conventions.lamp import LIGHT_CAPABILITIES, LightCommand, LightFeatures, WhiteRange, read_lamp, read_rgb
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.payload import (
    NO_READINGS,
    Readings,
    compact_json,
    meaning_reader,
    percent_of,
    to_json,
    to_text,
    unreadable,
)
from homebot.devices.value import PlainValue
from homebot.support.numbers import to_number, whole_number

_SWITCHED: Mapping[bytes, PlainValue] = {b"on": True, b"off": False, b"overpower": False}
"""The payloads of a relay or light; one that drew too much power was switched off."""

_MOVEMENTS: Mapping[bytes, PlainValue] = {b"open": "opening", b"close": "closing", b"stop": "stopped"}
_COMMANDS = {"open": b"open", "closed": b"close", "stopped": b"stop"}
_ENDS: Mapping[float, str] = {0.0: "closed", 100.0: "open"}


def build_relay(base: str, index: int, *, is_plug: bool) -> BytesPart:
    """Describe a relay, or a plug if it is a socket."""
    topic = f"{base}/relay/{index}"
    command = f"{topic}/command"
    part = BytesPart(f"relay:{index}", "plug" if is_plug else "switch", commands=command, advertised="relay")
    part.read_from(topic, meaning_reader("on_off", _SWITCHED))
    part.add_capability(
        "on_off", writer=bool_writer("on_off", lambda on: (Publication(command, b"on" if on else b"off"),))
    )
    return part


def build_roller(base: str, index: int) -> BytesPart:
    """Describe a roller. Before its calibration it reports the position -1."""
    topic, reader = f"{base}/roller/{index}", _RollerReader()
    command = f"{topic}/command"
    mover = option_writer("movement", _COMMANDS, lambda movement: (Publication(command, _COMMANDS[movement]),))
    pos = percent_writer("position", lambda to: (Publication(f"{command}/pos", b"%d" % round(to)),))
    part = BytesPart(f"roller:{index}", "window_covering", advertised="roller")
    part.read_from(topic, reader.read_movement)
    part.read_from(f"{topic}/pos", reader.read_position)
    part.add_command_topics(command, f"{command}/pos")
    part.add_capability("movement", writer=mover, options=("open", "closed", "opening", "closing", "stopped"))
    part.add_capability("position", writer=pos)
    return part


NO_VALVE = b"not_connected"
"""The state of the valve of a gas detector that has none."""

_VALVES: Mapping[bytes, PlainValue] = {
    **{name.encode(): name for name in ("closed", "opening", "closing")},
    b"opened": "open",
    **dict.fromkeys((NO_VALVE, b"unknown", b"failure", b"checking")),
}
_TURNS = {"open": b"open", "closed": b"close"}


def build_gas_valve(base: str, index: int) -> BytesPart:
    """Describe the valve that a gas detector closes."""
    command = f"{base}/valve/{index}/command"
    writer = option_writer("valve", _TURNS, lambda target: (Publication(command, _TURNS[target]),))
    part = BytesPart(f"valve:{index}", "water_valve", commands=command, advertised="valve", tag="gas")
    part.read_from(f"{base}/valve/{index}/state", meaning_reader("valve", _VALVES))
    part.add_capability("valve", writer=writer, options=("open", "closed", "opening", "closing"))
    return part


class _RollerReader:
    """Reader of the two messages of a roller: ``stop``, also at an end of its way, and its position."""

    def __init__(self) -> None:
        self._rests = False
        self._is_known = False
        self._position: float | None = None

    def read_movement(self, payload: bytes) -> Readings:
        movement = _MOVEMENTS.get(payload)
        if movement is None:
            return unreadable(payload, _MOVEMENTS)
        self._rests = movement == "stopped"
        if self._rests:
            return self._resting()
        self._is_known, self._position = True, None  # the last position is where it begins
        return {"movement": movement}

    def read_position(self, payload: bytes) -> Readings:
        number = to_number(to_text(payload))
        if number is None:
            return unreadable(payload, "a number")
        self._position, self._is_known = percent_of(number), True
        return {"position": self._position, **(self._resting() if self._rests else NO_READINGS)}

    def _resting(self) -> Readings:
        if not self._is_known:  # described anew, before the first position
            return NO_READINGS
        return {"movement": "stopped" if self._position is None else _ENDS.get(self._position, "stopped")}


_PRESSES = {
    "S": "single",
    "SS": "double",
    "SSS": "triple",
    "L": "long",
    "SL": "short_long",
    "LS": "long_short",
}


class Presses:
    """Filter of repeated presses, by the counter in the message.

    A device repeats its last press when its state is requested. The first message therefore only sets the counter,
    except for a device that wakes up to report it. The filter outlives the description of the device.
    """

    __slots__ = ("_count",)

    def __init__(self) -> None:
        self._count: object = None

    def read(self, payload: bytes, *, counts_first: bool) -> Readings:
        """Return the press in *payload* if it is new; the first one is new if *counts_first*."""
        message = to_json(payload)
        if not isinstance(message, dict):
            return NO_READINGS
        event, count = message.get("event"), whole_number(message.get("event_cnt"))
        is_first = self._count is None
        is_new = (count is None or count != self._count) and (counts_first or not is_first)
        self._count = 0 if count is None else count
        press = _PRESSES.get(event) if isinstance(event, str) else None
        return {"press": press} if is_new and press is not None else NO_READINGS


def build_input(
    base: str, index: int, presses: Presses, *, has_state: bool, has_events: bool, counts_first: bool
) -> BytesPart:
    """Describe an input, or a button if it has events; see :meth:`Presses.read` for *counts_first*."""
    part = BytesPart(f"input:{index}", "generic_switch" if has_events else "x_binary_sensor", advertised="input")
    if has_state:
        part.read_from(f"{base}/input/{index}", meaning_reader("state", {b"0": False, b"1": True}))
        part.add_capability("state")
    if has_events:
        part.read_events_from(f"{base}/input_event/{index}", partial(presses.read, counts_first=counts_first))
        part.add_capability("press", options=tuple(_PRESSES.values()))
    return part


_WHITES: Mapping[str, tuple[int, int]] = {"SHBDUO-1": (2700, 6500), "SHBLB-1": (3000, 6500), "SHCB-1": (3000, 6500)}
"""Warmest and coldest white in kelvin of the models that can change it."""

_ANY_WHITE = (2000, 6500)
_MAX_TRANSITION_MS = 5000  # milliseconds
_CHANNELS = ("red", "green", "blue")


def build_light(base: str, kind: str, index: int, model: str) -> BytesPart:
    """Describe a lamp of the *kind* ``light``, ``color`` or ``white``; an unknown *model* is empty."""
    white = _WHITES.get(model)
    modes = {"brightness"} | ({"rgb"} if kind == "color" else set()) | ({"color_temp"} if white else set())
    whites = WhiteRange(white or _ANY_WHITE, tuple(map(float, white or _ANY_WHITE)))
    lamp = _Gen1Lamp(f"{base}/{kind}/{index}", kind, has_white=white is not None)
    part = BytesPart(f"{kind}:{index}", "light", advertised=kind)
    part.read_from(lamp.topic, meaning_reader("on_off", _SWITCHED))
    part.read_from(f"{lamp.topic}/status", lamp.read)
    part.add_command_topics(f"{lamp.topic}/command", f"{lamp.topic}/set")
    features = LightFeatures(frozenset(modes), whites, only_in_bounds=True, most_seconds=math.inf)
    features.add_to(part, LIGHT_CAPABILITIES, lamp.publish)
    return part


@dataclass(frozen=True, slots=True)
class _Gen1Lamp:
    topic: str
    kind: str
    has_white: bool

    def read(self, payload: bytes) -> Readings:
        message = to_json(payload)
        if not isinstance(message, dict):
            return NO_READINGS
        is_color = self.kind == "color" and message.get("mode", "color") == "color"
        readings = dict(read_lamp(message, "ison", "gain" if is_color else "brightness"))
        kelvin = to_number(message.get("temp"))
        if self.has_white and kelvin is not None:
            readings["color_temperature"] = None if is_color or kelvin <= 0 else kelvin
        if self.kind == "color":
            readings["color"] = read_rgb(list(map(message.get, _CHANNELS))) if is_color else None
        return readings

    def publish(self, command: LightCommand) -> Publications:
        turn = "on" if command.on else "off"
        is_color, percent = self.kind == "color", command.percent
        fields: dict[str, object] = {"turn": turn}
        if command.color:
            channels = dict(zip(_CHANNELS, command.color, strict=True))
            fields |= {**({"mode": "color"} if self.has_white else {}), **channels, "white": 0}
        elif command.white is not None:
            fields |= {**({"mode": "white"} if is_color else {}), "temp": round(command.white)}
        if percent is not None:
            fields |= {"gain": percent} if is_color else {}
            fields |= {"brightness": percent} if self.has_white or not is_color else {}
        if command.transition:
            fields["transition"] = min(round(command.transition * 1000), _MAX_TRANSITION_MS)
        if len(fields) == 1 and self.kind != "white":
            return (Publication(f"{self.topic}/command", turn.encode()),)
        return (Publication(f"{self.topic}/set", compact_json(fields).encode()),)
