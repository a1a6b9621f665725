"""Parts of a Shelly of the first generation, by the topics it publishes. Pure.

Source: Shelly Gen1 API, MQTT; iobroker.shelly 12.0, ``lib/devices/gen1``.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping

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
from homebot.conventions.shelly.gen1_models import Gen1Model
from homebot.conventions.shelly.gen1_sensors import SENSORS, build_meter, build_motion, build_sensor, build_valve

__all__ = ["build_parts", "is_known_topic"]

_MAX_CHANNELS = 16
"""Most channels of one kind; no Shelly has more."""

_METER = ("power", "energy")
_EMETER = ("power", "voltage", "current", "total", "total_returned")
_RESTS: Mapping[str, tuple[str, ...]] = {
    "emeter": _EMETER,
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
    for kind, index in _channels(suffixes):
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


def _channels(suffixes: frozenset[str]) -> list[tuple[str, int]]:
    """Return kind and number of the channels, in the order of their parts."""
    matches = [match for match in map(_CHANNEL.fullmatch, suffixes) if match and int(match[2]) < _MAX_CHANNELS]
    found = {("input" if match[1] == "input_event" else match[1], int(match[2])) for match in matches}
    return sorted(found, key=lambda channel: (_RANKS[channel[0]], channel[1]))


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
            yield build_meter(base, f"emeter:{index}", _published(topic, _EMETER, suffixes))
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
