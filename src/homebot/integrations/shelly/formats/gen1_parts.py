"""Models of Shelly's first generation with the topics of each, and the parts that follow from published topics. Pure.

Topics of accessories, such as ``ext_temperature/0``, are added when they appear.

Source: Shelly Gen1 API, MQTT of Shelly1, Shelly2.5, Plug, Gas, Dimmer, Duo, Bulb and RGBW2, and of ``input/<i>`` and
``input_event/<i>``; ``transition`` is in milliseconds. iobroker.shelly 12.0, ``lib/devices/gen1``; aioshelly 13.35,
``const.py``.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

from homebot.conventions.command_values import bool_writer, option_writer, percent_writer
from homebot.conventions.description import DescribedPart, Publication, Publications
from homebot.conventions.lamp import LIGHT_CAPABILITIES, LightCommand, LightFeatures, WhiteRange, read_lamp, read_rgb
from homebot.conventions.part_builder import BytesPart, JsonPart
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
from homebot.integrations.shelly.formats.gen1_sensors import (
    SENSORS,
    build_meter,
    build_motion,
    build_sensor,
    build_valve,
)
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


@dataclass(frozen=True, slots=True)
class Gen1Model:
    """A model.

    Attributes:
        name: Its number, as announced.
        prefix: The beginning of its id, before ``-`` and the end of its hardware address; in small letters.
        topics: Its topics in every mode, below its own topic.
        modes: Its further topics, by mode.
        sleeps: Whether it is off the network most of the time, so that silence means nothing.
        is_plug: Whether its relay is a socket.
    """

    name: str
    prefix: str
    topics: frozenset[str]
    modes: Mapping[str, frozenset[str]]
    sleeps: bool = False
    is_plug: bool = False


_RELAY = "relay/{0}"
_METERED = "relay/{0} relay/{0}/power relay/{0}/energy"
_INPUT = "input/{0} input_event/{0}"
_ROLLER = "roller/0 roller/0/pos roller/0/power roller/0/energy"
_HEAT = "temperature overtemperature"
_EMETER = "emeter/{0}/power emeter/{0}/voltage emeter/{0}/total emeter/{0}/total_returned"
_BULB = "color/0 color/0/status"
_LIGHT = "light/0 light/0/status light/0/power light/0/energy"
_MOTION = "status"


def _topics(*patterns: str) -> frozenset[str]:
    return frozenset(topic for pattern in patterns for topic in pattern.split())


def _each(pattern: str, count: int) -> str:
    return " ".join(pattern.format(index) for index in range(count))


def _model(
    name: str,
    prefix: str,
    *patterns: str,
    modes: Mapping[str, str] | None = None,
    sleeps: bool = False,
    is_plug: bool = False,
) -> Gen1Model:
    by_mode = {mode: _topics(pattern) for mode, pattern in (modes or {}).items()}
    return Gen1Model(name, prefix, _topics(*patterns), MappingProxyType(by_mode), sleeps, is_plug)


MODELS: tuple[Gen1Model, ...] = (
    _model("SHSW-1", "shelly1", _each(_RELAY, 1), _each(_INPUT, 1)),
    _model("SHSW-PM", "shelly1pm", _each(_METERED, 1), _each(_INPUT, 1), _HEAT),
    _model("SHSW-L", "shelly1l", _each(_METERED, 1), _each(_INPUT, 2), _HEAT),
    _model(
        "SHSW-21",
        "shellyswitch",
        modes={"relay": f"{_each(_RELAY, 2)} {_each(_INPUT, 2)} relay/power relay/energy", "roller": _ROLLER},
    ),
    _model(
        "SHSW-25",
        "shellyswitch25",
        _HEAT,
        modes={"relay": f"{_each(_METERED, 2)} {_each(_INPUT, 2)}", "roller": _ROLLER},
    ),
    _model("SHSW-44", "shelly4pro", _each(_METERED, 4), _each("input/{0}", 4)),
    _model("SHAIR-1", "shellyair", _each(_METERED, 1), _each(_INPUT, 1)),
    _model("SHPLG-1", "shellyplug", _each(_METERED, 1), is_plug=True),
    _model("SHPLG2-1", "shellyplug", _each(_METERED, 1), is_plug=True),
    _model("SHPLG-S", "shellyplug-s", _each(_METERED, 1), _HEAT, is_plug=True),
    _model("SHPLG-U1", "shellyplug-u1", _each(_METERED, 1), is_plug=True),
    _model("SHUNI-1", "shellyuni", _each(_RELAY, 2), _each(_INPUT, 2), "adc/0"),
    _model("SHEM", "shellyem", _each(_EMETER, 2), _each(_RELAY, 1)),
    _model("SHEM-3", "shellyem3", _each(_EMETER, 3), _each("emeter/{0}/current", 3), _each(_RELAY, 1)),
    _model("SHIX3-1", "shellyix3", _each(_INPUT, 3)),
    _model("SHBTN-1", "shellybutton1", "input_event/0 sensor/battery", sleeps=True),
    _model("SHBTN-2", "shellybutton1", "input_event/0 sensor/battery", sleeps=True),
    _model("SHDM-1", "shellydimmer", "light/0 light/0/status light/0/power", _each(_INPUT, 2), _HEAT),
    _model("SHDM-2", "shellydimmer2", "light/0 light/0/status light/0/power", _each(_INPUT, 2), _HEAT),
    _model("SHDIMW-1", "shellydimmerw1", "light/0 light/0/status light/0/power", _each(_INPUT, 1), _HEAT),
    _model("SHBDUO-1", "shellybulbduo", _LIGHT),
    _model("SHVIN-1", "shellyvintage", _LIGHT),
    _model("SHBVIN-1", "shellyvintage", _LIGHT),
    _model("SHBLB-1", "shellybulb", _BULB),
    _model("SHCB-1", "shellycolorbulb", _BULB),
    _model("SH2LED", "shelly2led", _BULB),
    _model("SH2LED-1", "shelly2led", _BULB),
    _model(
        "SHRGBW2",
        "shellyrgbw2",
        _each(_INPUT, 1),
        modes={"color": _BULB, "white": _each("white/{0} white/{0}/status", 4)},
    ),
    _model("SHHT-1", "shellyht", "sensor/temperature sensor/humidity sensor/battery", sleeps=True),
    _model("SHWT-1", "shellyflood", "sensor/flood sensor/temperature sensor/battery", sleeps=True),
    _model("SHSM-01", "shellysmoke", "sensor/smoke sensor/temperature sensor/battery", sleeps=True),
    _model("SHSM-02", "shellysmoke2", "sensor/smoke sensor/battery", sleeps=True),
    _model("SHGS-1", "shellygas", "sensor/gas sensor/concentration"),
    _model(
        "SHDW-1",
        "shellydw",
        "sensor/state sensor/lux sensor/tilt sensor/vibration sensor/battery",
        sleeps=True,
    ),
    _model(
        "SHDW-2",
        "shellydw2",
        "sensor/state sensor/lux sensor/tilt sensor/vibration sensor/temperature sensor/battery",
        sleeps=True,
    ),
    _model("SHSEN-1", "shellysense", "sensor/motion sensor/lux sensor/temperature sensor/humidity sensor/battery"),
    _model("SHMOS-01", "shellymotionsensor", _MOTION),
    _model("SHMOS-02", "shellymotion2", _MOTION),
    _model("SHTRV-01", "shellytrv", _MOTION),
)
"""All models. Of a model with modes, the announced mode selects the topics, or else the topics seen."""


def find_model(name: str, device_id: str) -> Gen1Model:
    """Return the model by its number, or else by the beginning of *device_id*; if both are unknown, one without."""
    return _BY_NAME.get(name) or _BY_PREFIX.get(device_id.casefold().rpartition("-")[0], _UNKNOWN)


_UNKNOWN = _model("", "")
_BY_NAME = {model.name: model for model in MODELS}
_BY_PREFIX = {model.prefix: model for model in reversed(MODELS)}


_MAX_CHANNELS = 16
"""Most channels of one kind; no Shelly has more."""

_METER = ("power", "energy")
_OF_EMETER = ("power", "voltage", "current", "total", "total_returned")
_RESTS: Mapping[str, tuple[str, ...]] = {
    "emeter": _OF_EMETER,
    "relay": ("", *_METER),
    "roller": ("", "pos", *_METER),
    "valve": ("state",),
    **dict.fromkeys(("light", "color", "white"), ("", "status", *_METER)),
    **dict.fromkeys(("input", "input_event", "adc", "ext_temperature", "ext_humidity", "ext_switch"), ("",)),
}
"""Topics below a channel, by its kind; the order is that of the parts."""

_CHANNEL = re.compile(rf"({'|'.join(_RESTS)})/([0-9]{{1,2}})(?:/([a-z_]+))?")
_RANKS = {kind: rank for rank, kind in enumerate(_RESTS)}
_WHOLE = frozenset({"relay/power", "relay/energy", "status"})


def is_known_topic(suffix: str) -> bool:
    """Return whether *suffix*, a topic below the device's own, belongs to a part."""
    if suffix in SENSORS or suffix in _WHOLE:
        return True
    match = _CHANNEL.fullmatch(suffix)
    return match is not None and int(match[2]) < _MAX_CHANNELS and (match[3] or "") in _RESTS[match[1]]


def build_parts(
    base: str, model: Gen1Model, suffixes: frozenset[str], presses: defaultdict[int, Presses]
) -> tuple[DescribedPart, ...]:
    """Return the parts of the device that publishes *suffixes*, the main one first.

    Args:
        base: Its own topic.
        suffixes: The known topics below it.
        presses: Reports of each of its inputs, which outlive the description.
    """
    parts: list[BytesPart | JsonPart] = []
    matches = [match for match in map(_CHANNEL.fullmatch, suffixes) if match and int(match[2]) < _MAX_CHANNELS]
    channels = {("input" if match[1] == "input_event" else match[1], int(match[2])) for match in matches}
    for kind, index in sorted(channels, key=lambda channel: (_RANKS[channel[0]], channel[1])):
        parts.extend(_build_channel(base, kind, index, suffixes, model, presses))
    if "relay/power" in suffixes and "relay/0/power" not in suffixes:
        parts.append(build_meter(base, "meter", {name: f"relay/{name}" for name in _METER}))
    parts.extend(build_sensor(base, SENSORS[suffix]) for suffix in SENSORS if suffix in suffixes)
    if "status" in suffixes:
        is_valve, has_thermometer = model.name == "SHTRV-01", model.name != "SHMOS-01"
        parts.extend(build_valve(base) if is_valve else build_motion(base, has_thermometer=has_thermometer))
    for part in parts[:1]:
        part.add_state_request(Publication(f"{base}/command", b"update"))
    return tuple(part.build() for part in parts)


def _build_channel(
    base: str,
    kind: str,
    index: int,
    suffixes: frozenset[str],
    model: Gen1Model,
    presses: defaultdict[int, Presses],
) -> Iterator[BytesPart]:
    topic = f"{kind}/{index}"
    match kind:
        case "relay":
            yield build_relay(base, index, is_plug=model.is_plug)
        case "roller":
            yield build_roller(base, index)
        case "valve":
            yield build_gas_valve(base, index)
        case "light" | "color" | "white":
            yield build_light(base, kind, index, model.name)
        case "input":
            yield build_input(
                base,
                index,
                presses[index],
                has_state=topic in suffixes,
                has_events=f"input_event/{index}" in suffixes,
                counts_first=model.sleeps,
            )
        case "emeter":
            yield build_meter(base, f"emeter:{index}", _find_published(topic, _OF_EMETER, suffixes))
            return
        case "adc":
            yield build_meter(base, f"adc:{index}", {"voltage": topic})
        case _:
            yield build_sensor(base, SENSORS[kind], index)
    if meter := _find_published(topic, _METER, suffixes):
        yield build_meter(base, f"{kind}:{index}/meter", meter)


def _find_published(topic: str, names: tuple[str, ...], suffixes: frozenset[str]) -> dict[str, str]:
    """Return the topics below *topic* that the device publishes, by their last level."""
    return {name: f"{topic}/{name}" for name in names if f"{topic}/{name}" in suffixes}
