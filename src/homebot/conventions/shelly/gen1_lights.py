"""Lamps of Shelly's first generation: dimmers, white bulbs, colour bulbs and strips. Pure.

Source: Shelly Gen1 API, MQTT of Dimmer, Duo, Bulb and RGBW2; ``transition`` is in milliseconds.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import require_bool, require_color, require_number
from homebot.conventions.decode import NO_READINGS, Readings, to_json, to_text
from homebot.conventions.description import Publication
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.shelly.gen1_controls import SWITCHED
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.table_codec import raw_bytes
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["build_light"]

_WHITES: Mapping[str, tuple[int, int]] = {"SHBDUO-1": (2700, 6500), "SHBLB-1": (3000, 6500), "SHCB-1": (3000, 6500)}
"""Warmest and coldest white in kelvin of the models that can change it."""

_ANY_WHITE = (2000, 6500)
_LONGEST_TRANSITION = 5000
_CHANNELS = ("red", "green", "blue")


def build_light(topics: Gen1Topics, kind: str, index: int, model: str) -> BytesPart:
    """Describe a lamp.

    Args:
        topics: Those of its device.
        kind: ``light``, ``color`` or ``white``: below which topic it is.
        index: Its channel.
        model: Number of its device's model; empty where that is not known.
    """
    lamp = _Gen1Lamp(topics.at(f"{kind}/{index}"), kind, _WHITES.get(model))
    part = PartBuilder(raw_bytes, f"{kind}:{index}", "light", advertised=kind)
    part.read_from(lamp.topic, _read_switch)
    part.read_from(f"{lamp.topic}/status", lamp.read)
    part.add_command_topics(f"{lamp.topic}/command")
    part.add_command_topics(f"{lamp.topic}/set")
    part.add_capability("on_off", writer=lamp.switch)
    part.add_capability("level", writer=lamp.dim)
    if lamp.white is not None:
        part.add_capability("color_temperature", writer=lamp.warm, bounds=tuple(map(float, lamp.white)))
    if kind == "color":
        part.add_capability("color", writer=lamp.paint)
    return part


@dataclass(frozen=True, slots=True)
class _Gen1Lamp:
    topic: str
    kind: str
    white: tuple[int, int] | None

    def read(self, payload: bytes) -> Readings:
        message = to_json(payload)
        if not isinstance(message, dict):
            return NO_READINGS
        is_color = self.kind == "color" and message.get("mode", "color") == "color"
        found: dict[str, PlainValue] = {}
        if isinstance(on := message.get("ison"), bool):
            found["on_off"] = on
        level = to_number(message.get("gain" if is_color else "brightness"))
        if level is not None and 0 <= level <= 100:
            found["level"] = level
        kelvin = to_number(message.get("temp"))
        if self.white is not None and kelvin is not None:
            found["color_temperature"] = None if is_color or kelvin <= 0 else kelvin
        if self.kind == "color":
            found["color"] = _color(message) if is_color else None
        return found

    def switch(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        turn = "on" if require_bool("on_off", value) else "off"
        if transition or self.kind == "white":
            return self._set({"turn": turn}, transition)
        return (Publication(f"{self.topic}/command", turn.encode()),)

    def dim(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        level = require_number("level", value, 0, 100, "%")
        if level == 0:
            return self.switch(value=False, transition=transition)
        percent = max(1, round(level))
        if self.kind != "color":
            return self._set({"turn": "on", "brightness": percent}, transition)
        both = {"gain": percent} if self.white is None else {"gain": percent, "brightness": percent}
        return self._set({"turn": "on", **both}, transition)

    def warm(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        warmest, coldest = self.white or _ANY_WHITE
        kelvin = round(require_number("color_temperature", value, warmest, coldest, "K"))
        mode = {"mode": "white"} if self.kind == "color" else {}
        return self._set({"turn": "on", **mode, "temp": kelvin}, transition)

    def paint(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        hue, saturation = require_color(value)
        rgb = from_hue_saturation("rgb", hue, saturation, _ANY_WHITE)
        mode = {} if self.white is None else {"mode": "color"}
        channels = {name: int(one) for name, one in zip(_CHANNELS, rgb, strict=True)}
        return self._set({"turn": "on", **mode, **channels, "white": 0}, transition)

    def _set(self, fields: Mapping[str, object], transition: float) -> tuple[Publication, ...]:
        if transition:
            fields = {**fields, "transition": min(round(transition * 1000), _LONGEST_TRANSITION)}
        return (Publication(f"{self.topic}/set", json.dumps(fields, separators=(",", ":")).encode()),)


def _read_switch(payload: bytes) -> Readings:
    return SWITCHED.get(to_text(payload) or "", NO_READINGS)


def _color(message: Mapping[str, object]) -> tuple[float, ...] | None:
    channels = [to_number(message.get(name)) for name in _CHANNELS]
    known = tuple(one for one in channels if one is not None and 0 <= one <= 255)
    return to_hue_saturation("rgb", known, _ANY_WHITE) if len(known) == len(_CHANNELS) else None
