"""Models of Shelly's first generation with the topics of each, and the parts that follow from published topics. Pure.

Topics of accessories, such as ``ext_temperature/0``, are added when they appear.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0, ``lib/devices/gen1``; aioshelly 13.35, ``const.py``.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import BytesPart, JsonPart
from homebot.integrations.shelly.formats.gen1_controls import (
    Presses,
    build_gas_valve,
    build_input,
    build_light,
    build_relay,
    build_roller,
)
from homebot.integrations.shelly.formats.gen1_sensors import (
    SENSORS,
    build_meter,
    build_motion,
    build_sensor,
    build_valve,
)


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
            yield build_meter(base, f"emeter:{index}", _published(topic, _OF_EMETER, suffixes))
            return
        case "adc":
            yield build_meter(base, f"adc:{index}", {"voltage": topic})
        case _:
            yield build_sensor(base, SENSORS[kind], index)
    if meter := _published(topic, _METER, suffixes):
        yield build_meter(base, f"{kind}:{index}/meter", meter)


def _published(topic: str, names: tuple[str, ...], suffixes: frozenset[str]) -> dict[str, str]:
    """Return the topics below *topic* that the device publishes, by their last level."""
    return {name: f"{topic}/{name}" for name in names if f"{topic}/{name}" in suffixes}
