"""Parts of a Shelly of the first generation, by the topics it publishes. Pure.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import BytesPart, JsonPart
from homebot.conventions.shelly.gen1_controls import (
    Presses,
    build_gas_valve,
    build_input,
    build_light,
    build_relay,
    build_roller,
)
from homebot.conventions.shelly.gen1_models import Gen1Model, Gen1Topics
from homebot.conventions.shelly.gen1_sensors import SENSORS, build_meter, build_motion, build_sensor, build_valve

__all__ = ["build_parts", "is_known_topic"]

_MAX_CHANNELS = 16
"""Most channels of one kind; no Shelly has more."""

_CHANNEL = re.compile(
    r"(?P<kind>relay|roller|light|color|white|valve|input|input_event|emeter|adc|ext_temperature|ext_humidity|ext_switch)"
    r"/(?P<index>[0-9]{1,2})(?:/(?P<rest>[a-z_]+))?"
)
_WHOLE = frozenset({"relay/power", "relay/energy", "status"})
_METERED = frozenset({"", "power", "energy"})
_PLAIN = frozenset({""})
_METER = ("power", "energy")
_EMETER = ("power", "voltage", "current", "total", "total_returned")
_RESTS: Mapping[str, frozenset[str]] = {
    "emeter": frozenset(_EMETER),
    "relay": _METERED,
    "roller": _METERED | {"pos"},
    "valve": frozenset({"state"}),
    **dict.fromkeys(("light", "color", "white"), _METERED | {"status"}),
    **dict.fromkeys(("input", "input_event", "adc", "ext_temperature", "ext_humidity", "ext_switch"), _PLAIN),
}
"""Topics below a channel, by its kind; the order is that of the parts."""

_RANKS = {kind: rank for rank, kind in enumerate(_RESTS)}


class _Channel(NamedTuple):
    kind: str
    number: int

    @property
    def topic(self) -> str:
        return f"{self.kind}/{self.number}"


def is_known_topic(suffix: str) -> bool:
    """Return whether *suffix*, a topic below the device's own, belongs to a part."""
    if suffix in SENSORS or suffix in _WHOLE:
        return True
    match = _CHANNEL.fullmatch(suffix)
    return match is not None and int(match["index"]) < _MAX_CHANNELS and (match["rest"] or "") in _RESTS[match["kind"]]


def build_parts(
    topics: Gen1Topics, model: Gen1Model, suffixes: frozenset[str], presses: defaultdict[int, Presses]
) -> tuple[DescribedPart, ...]:
    """Return the parts of the device that publishes *suffixes*, the main one first.

    Args:
        suffixes: The known topics below its own.
        presses: Reports of each of its inputs, which outlive the description.
    """
    parts: list[BytesPart | JsonPart] = [
        part for channel in _channels(suffixes) for part in _build_channel(topics, channel, suffixes, model, presses)
    ]
    if "relay/power" in suffixes and "relay/0/power" not in suffixes:
        parts.append(build_meter(topics, "meter", {"power": "relay/power", "energy": "relay/energy"}))
    parts.extend(build_sensor(topics, SENSORS[suffix]) for suffix in SENSORS if suffix in suffixes)
    if "status" in suffixes:
        is_valve, has_thermometer = model.name == "SHTRV-01", model.name != "SHMOS-01"
        parts.extend(build_valve(topics) if is_valve else build_motion(topics, has_thermometer=has_thermometer))
    for part in parts[:1]:
        part.add_state_request(Publication(f"{topics.topic}/command", b"update"))
    return tuple(part.build() for part in parts)


def _channels(suffixes: frozenset[str]) -> tuple[_Channel, ...]:
    found = {
        _Channel("input" if match["kind"] == "input_event" else match["kind"], int(match["index"]))
        for suffix in suffixes
        if (match := _CHANNEL.fullmatch(suffix)) and int(match["index"]) < _MAX_CHANNELS
    }
    return tuple(sorted(found, key=lambda channel: (_RANKS[channel.kind], channel.number)))


def _build_channel(
    topics: Gen1Topics,
    channel: _Channel,
    suffixes: frozenset[str],
    model: Gen1Model,
    presses: defaultdict[int, Presses],
) -> Iterator[BytesPart]:
    kind, index = channel
    match kind:
        case "relay":
            yield build_relay(topics, index, is_plug=model.is_plug)
        case "roller":
            yield build_roller(topics, index)
        case "valve":
            yield build_gas_valve(topics, index)
        case "light" | "color" | "white":
            yield build_light(topics, kind, index, model.name)
        case "input":
            yield build_input(
                topics,
                index,
                presses[index],
                has_state=channel.topic in suffixes,
                has_events=f"input_event/{index}" in suffixes,
                counts_first=model.sleeps,
            )
        case "emeter":
            yield build_meter(topics, f"emeter:{index}", _published(channel, _EMETER, suffixes))
        case "adc":
            yield build_meter(topics, f"adc:{index}", {"voltage": channel.topic})
        case _:
            yield build_sensor(topics, SENSORS[kind], index)
    if kind != "emeter":
        yield from _build_meter_of_channel(topics, channel, suffixes)


def _build_meter_of_channel(topics: Gen1Topics, channel: _Channel, suffixes: frozenset[str]) -> Iterator[BytesPart]:
    if meter := _published(channel, _METER, suffixes):
        kind, index = channel
        yield build_meter(topics, f"{kind}:{index}/meter", meter)


def _published(channel: _Channel, names: tuple[str, ...], suffixes: frozenset[str]) -> dict[str, str]:
    """Return the published topics of *names* below *channel*, by name."""
    return {name: f"{channel.topic}/{name}" for name in names if f"{channel.topic}/{name}" in suffixes}
