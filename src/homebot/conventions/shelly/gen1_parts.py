"""Parts of a Shelly of the first generation, by the topics it publishes. Pure.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import BytesPart
from homebot.conventions.shelly.gen1_controls import Presses, build_input, build_light, build_relay, build_roller
from homebot.conventions.shelly.gen1_models import Gen1Model, Gen1Topics
from homebot.conventions.shelly.gen1_sensors import SENSORS, build_meter, build_motion, build_sensor, build_valve

__all__ = ["MAX_CHANNELS", "build_parts", "is_known_topic"]

MAX_CHANNELS = 16
"""Channels of one kind that a device may have: more is nothing Shelly made."""


def is_known_topic(suffix: str) -> bool:
    """Return whether *suffix*, a topic below the device's own, belongs to a part."""
    if suffix in SENSORS or suffix in _WHOLE:
        return True
    match = _CHANNEL.fullmatch(suffix)
    return match is not None and int(match["index"]) < MAX_CHANNELS and (match["rest"] or "") in _RESTS[match["kind"]]


def build_parts(
    topics: Gen1Topics, model: Gen1Model | None, suffixes: frozenset[str], presses: defaultdict[int, Presses]
) -> tuple[DescribedPart, ...]:
    """Return the parts of the device at *topics* that publishes *suffixes*; first what it is there for.

    What it reported of each of its inputs is kept in *presses*, which outlives the description.
    """
    parts: list[BytesPart] = []
    for channel in _channels(suffixes):
        if channel.kind == "input":
            parts.append(_input(topics, channel, suffixes, model, presses[channel.index]))
            continue
        parts.extend(part for build in _BUILDERS[channel.kind] if (part := build(topics, channel, suffixes, model)))
    if "relay/power" in suffixes and "relay/0/power" not in suffixes:
        parts.append(build_meter(topics, "meter", {"power": "relay/power", "energy": "relay/energy"}))
    parts.extend(build_sensor(topics, SENSORS[suffix]) for suffix in SENSORS if suffix in suffixes)
    if "status" in suffixes:
        name = model.name if model is not None else ""
        parts.extend(
            build_valve(topics) if name == "SHTRV-01" else build_motion(topics, has_thermometer=name != "SHMOS-01")
        )
    for part in parts[:1]:
        part.add_state_request(Publication(f"{topics.topic}/command", b"update"))
    return tuple(part.build() for part in parts)


@dataclass(frozen=True, slots=True)
class _Channel:
    kind: str
    index: int

    @property
    def topic(self) -> str:
        return f"{self.kind}/{self.index}"


_Build = Callable[[Gen1Topics, _Channel, frozenset[str], Gen1Model | None], BytesPart | None]

_CHANNEL = re.compile(
    r"(?P<kind>relay|roller|light|color|white|input|input_event|emeter|adc|ext_temperature|ext_humidity|ext_switch)"
    r"/(?P<index>[0-9]{1,2})(?:/(?P<rest>[a-z_]+))?"
)
_WHOLE = frozenset({"relay/power", "relay/energy", "status"})
_METERED = frozenset({"", "power", "energy"})
_RESTS: Mapping[str, frozenset[str]] = {
    "emeter": frozenset({"power", "voltage", "current", "total", "total_returned"}),
    "relay": _METERED,
    "roller": _METERED | {"pos"},
    "light": _METERED | {"status"},
    "color": _METERED | {"status"},
    "white": _METERED | {"status"},
    "input": frozenset({""}),
    "input_event": frozenset({""}),
    "adc": frozenset({""}),
    "ext_temperature": frozenset({""}),
    "ext_humidity": frozenset({""}),
    "ext_switch": frozenset({""}),
}


def _channels(suffixes: frozenset[str]) -> tuple[_Channel, ...]:
    found = {
        _Channel("input" if match["kind"] == "input_event" else match["kind"], int(match["index"]))
        for suffix in suffixes
        if (match := _CHANNEL.fullmatch(suffix)) and int(match["index"]) < MAX_CHANNELS
    }
    ranks = {kind: rank for rank, kind in enumerate(_RESTS)}
    return tuple(sorted(found, key=lambda one: (ranks[one.kind], one.index)))


def _relay(topics: Gen1Topics, channel: _Channel, _suffixes: frozenset[str], model: Gen1Model | None) -> BytesPart:
    return build_relay(topics, channel.index, is_plug=model is not None and model.is_plug)


def _roller(topics: Gen1Topics, channel: _Channel, _suffixes: frozenset[str], _model: Gen1Model | None) -> BytesPart:
    return build_roller(topics, channel.index)


def _light(topics: Gen1Topics, channel: _Channel, _suffixes: frozenset[str], model: Gen1Model | None) -> BytesPart:
    return build_light(topics, channel.kind, channel.index, "" if model is None else model.name)


def _input(
    topics: Gen1Topics, channel: _Channel, suffixes: frozenset[str], model: Gen1Model | None, presses: Presses
) -> BytesPart:
    return build_input(
        topics,
        channel.index,
        presses,
        has_state=channel.topic in suffixes,
        has_events=f"input_event/{channel.index}" in suffixes,
        counts_first=model is not None and model.sleeps,
    )


def _meter(
    topics: Gen1Topics, channel: _Channel, suffixes: frozenset[str], _model: Gen1Model | None
) -> BytesPart | None:
    topic = channel.topic
    suffix_by_name = {name: f"{topic}/{name}" for name in ("power", "energy") if f"{topic}/{name}" in suffixes}
    return build_meter(topics, f"{channel.kind}:{channel.index}/meter", suffix_by_name) if suffix_by_name else None


def _emeter(topics: Gen1Topics, channel: _Channel, suffixes: frozenset[str], _model: Gen1Model | None) -> BytesPart:
    names = ("power", "voltage", "current", "total", "total_returned")
    suffix_by_name = {name: f"{channel.topic}/{name}" for name in names if f"{channel.topic}/{name}" in suffixes}
    return build_meter(topics, f"emeter:{channel.index}", suffix_by_name)


def _adc(topics: Gen1Topics, channel: _Channel, _suffixes: frozenset[str], _model: Gen1Model | None) -> BytesPart:
    return build_meter(topics, f"adc:{channel.index}", {"voltage": channel.topic})


def _external(topics: Gen1Topics, channel: _Channel, _suffixes: frozenset[str], _model: Gen1Model | None) -> BytesPart:
    return build_sensor(topics, SENSORS[channel.kind], channel.index)


_BUILDERS: Mapping[str, tuple[_Build, ...]] = {
    "relay": (_relay, _meter),
    "roller": (_roller, _meter),
    "light": (_light, _meter),
    "color": (_light, _meter),
    "white": (_light, _meter),
    "emeter": (_emeter,),
    "adc": (_adc,),
    "ext_temperature": (_external,),
    "ext_humidity": (_external,),
    "ext_switch": (_external,),
}
