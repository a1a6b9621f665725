"""Lamps of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Light, CCT, RGB, RGBW and RGBCCT; ``transition_duration`` is in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.command_values import require_bool, require_color, require_number
from homebot.conventions.decode import Readings
from homebot.conventions.description import Publication
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["LIGHTS", "build_light"]

_ANY_WHITE = (2700, 6500)
_LEAST_TRANSITION = 0.5
_CHANNELS = 3


@dataclass(frozen=True, slots=True)
class _LightKind:
    namespace: str
    has_white: bool = False
    has_color: bool = False
    modes: tuple[str, str] | None = None


LIGHTS: Mapping[str, _LightKind] = MappingProxyType(
    {
        "light": _LightKind("Light"),
        "cct": _LightKind("CCT", has_white=True),
        "rgb": _LightKind("RGB", has_color=True),
        "rgbw": _LightKind("RGBW", has_color=True),
        "rgbcct": _LightKind("RGBCCT", has_white=True, has_color=True, modes=("cct", "rgb")),
    }
)
"""The components that are lamps."""


def build_light(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a lamp."""
    lamp = _Gen2Lamp(component, LIGHTS[component.kind], _white_range(component.config))
    part = component.part("", "light")
    component.read_status(part, lamp.decode)
    component.add_command_topic(part)
    part.add_capability("on_off", writer=lamp.switch)
    part.add_capability("level", writer=lamp.dim)
    if lamp.kind.has_white:
        part.add_capability("color_temperature", writer=lamp.warm, bounds=tuple(map(float, lamp.white)))
    if lamp.kind.has_color:
        part.add_capability("color", writer=lamp.paint)
    return (part,)


@dataclass(frozen=True, slots=True)
class _Gen2Lamp:
    component: ShellyComponent
    kind: _LightKind
    white: tuple[int, int]

    def decode(self, status: Fields) -> Readings:
        found: dict[str, PlainValue] = {}
        if isinstance(on := status.get("output"), bool):
            found["on_off"] = on
        level = to_number(status.get("brightness"))
        if level is not None and 0 <= level <= 100:
            found["level"] = level
        mode = status.get("mode")
        if self.kind.has_white and (kelvin := to_number(status.get("ct"))) is not None:
            found["color_temperature"] = kelvin if kelvin > 0 and mode != "rgb" else None
        if self.kind.has_color and (rgb := _rgb(status.get("rgb"))) is not None:
            found["color"] = to_hue_saturation("rgb", rgb, _ANY_WHITE) if mode != "cct" else None
        return found

    def switch(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        return self._set(transition, on=require_bool("on_off", value))

    def dim(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        level = require_number("level", value, 0, 100, "%")
        if level == 0:
            return self._set(transition, on=False)
        return self._set(transition, on=True, brightness=max(1, round(level)))

    def warm(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        kelvin = round(require_number("color_temperature", value, *self.white, "K"))
        mode = {} if self.kind.modes is None else {"mode": self.kind.modes[0]}
        return self._set(transition, on=True, **mode, ct=kelvin)

    def paint(self, value: PlainValue, transition: float) -> tuple[Publication, ...]:
        hue, saturation = require_color(value)
        rgb = [int(one) for one in from_hue_saturation("rgb", hue, saturation, _ANY_WHITE)]
        mode = {} if self.kind.modes is None else {"mode": self.kind.modes[1]}
        white = {"white": 0} if self.kind.namespace == "RGBW" else {}
        return self._set(transition, on=True, **mode, rgb=rgb, **white)

    def _set(self, transition: float, **params: object) -> tuple[Publication, ...]:
        if transition:
            params["transition_duration"] = max(_LEAST_TRANSITION, round(transition, 1))
        return self.component.call(f"{self.kind.namespace}.Set", **params)


def _rgb(value: object) -> tuple[float, ...] | None:
    if not isinstance(value, list) or len(value) != _CHANNELS:
        return None
    channels = tuple(one for one in map(to_number, value) if one is not None and 0 <= one <= 255)
    return channels if len(channels) == _CHANNELS else None


def _white_range(config: Fields) -> tuple[int, int]:
    bounds = config.get("ct_range")
    if isinstance(bounds, list) and len(bounds) == 2:
        warmest, coldest = (to_number(one) for one in bounds)
        if warmest is not None and coldest is not None and 1000 <= warmest < coldest <= 40_000:
            return round(warmest), round(coldest)
    return _ANY_WHITE
