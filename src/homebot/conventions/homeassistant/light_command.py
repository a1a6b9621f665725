"""Command to a lamp, before its schema writes it; the same for all three schemas. Pure.

Source: Home Assistant core 2025.4, ``components/light/__init__.py``, the service ``light.turn_on``.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from homebot.conventions.command_values import (
    require_bool,
    require_color,
    require_number,
    require_option,
    require_transition,
)
from homebot.conventions.description import Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.light_color import (
    Channels,
    KelvinRange,
    from_hue_saturation,
    kelvin_mired,
    mired_bounds,
)
from homebot.devices.value import PlainValue

__all__ = ["LightCommand", "LightFeatures", "WhiteRange", "read_white_range"]

_MOST_SECONDS = 6_553.0
"""Longest transition in Home Assistant."""


class LightCommand(NamedTuple):
    """One command to a lamp.

    Attributes:
        brightness: 1 to 255; None if unchanged.
        kelvin: Its white; None if unchanged.
        mode: The channels of *color*; empty if unchanged.
        effect: Its effect; empty if unchanged.
        transition: Seconds of the change; None for the default of the device.
    """

    on: bool
    brightness: int | None = None
    kelvin: int | None = None
    mode: str = ""
    color: Channels = ()
    effect: str = ""
    transition: float | None = None


Publish: TypeAlias = Callable[[LightCommand], Publications]


class WhiteRange(NamedTuple):
    """The whites of a lamp.

    Attributes:
        kelvins: Warmest and coldest, for Home Assistant's calculations.
        bounds: The lowest and the highest accepted kelvin; see :func:`mired_bounds`.
    """

    kelvins: KelvinRange
    bounds: tuple[float, float]


@dataclass(frozen=True, slots=True)
class LightFeatures:
    """The capabilities of a lamp, and their values.

    Attributes:
        modes: Its colour modes, with the names of Home Assistant.
        any_effect: Whether it also accepts unlisted effects.
        color_mode: The channels of commanded colours; empty for a lamp without colours.
    """

    modes: frozenset[str]
    white: WhiteRange
    effects: tuple[str, ...] = ()
    any_effect: bool = False
    has_level: bool = field(init=False)
    has_white: bool = field(init=False)
    color_mode: str = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "has_level", not self.modes <= _NO_LEVEL)
        object.__setattr__(self, "has_white", "color_temp" in self.modes)
        color_mode = "" if self.modes.isdisjoint(_PREFERRED) else next(one for one in _PREFERRED if one in self.modes)
        object.__setattr__(self, "color_mode", color_mode)

    def add_to(self, entity: Entity, readable: Container[str], publish: Publish) -> None:
        """Add the capabilities to *entity*; *readable* ones are reported, and *publish* encodes a command."""
        writers = _LightWriters(self, publish)
        entity.add_capability("on_off", readable="on_off" in readable, writer=writers.on_off)
        if self.has_level:
            entity.add_capability("level", readable="level" in readable, writer=writers.level)
        if self.has_white:
            entity.add_capability(
                "color_temperature",
                readable="color_temperature" in readable,
                writer=writers.white,
                bounds=self.white.bounds,
            )
        if self.color_mode:
            entity.add_capability("color", readable="color" in readable, writer=writers.color)
        if self.effects or self.any_effect:
            entity.add_capability("effect", readable="effect" in readable, writer=writers.effect, options=self.effects)


@dataclass(slots=True, eq=False)
class _LightWriters:
    """Writers of one lamp, one for each capability."""

    lamp: LightFeatures
    publish: Publish

    def on_off(self, value: PlainValue, transition: float) -> Publications:
        return _publish(self.publish, LightCommand(on=require_bool("on_off", value)), transition)

    def level(self, value: PlainValue, transition: float) -> Publications:
        brightness = round(255 * require_number("level", value, 0, 100, "%") / 100)
        command = LightCommand(on=True, brightness=brightness) if brightness else LightCommand(on=False)
        return _publish(self.publish, command, transition)

    def white(self, value: PlainValue, transition: float) -> Publications:
        low, high = self.lamp.white.bounds
        kelvin = require_number(
            "color_temperature", value, min(low, _LEAST_KELVIN), max(high, _MOST_WANTED_KELVIN), "K"
        )
        return _publish(self.publish, LightCommand(on=True, kelvin=int(kelvin)), transition)

    def color(self, value: PlainValue, transition: float) -> Publications:
        hue, saturation = require_color(value)
        color = from_hue_saturation(self.lamp.color_mode, hue, saturation, self.lamp.white.kelvins)
        return _publish(self.publish, LightCommand(on=True, mode=self.lamp.color_mode, color=color), transition)

    def effect(self, value: PlainValue, transition: float) -> Publications:
        if self.lamp.effects or not isinstance(value, str):
            require_option("effect", value, self.lamp.effects)
        return _publish(self.publish, LightCommand(on=True, effect=str(value)), transition)


def _publish(publish: Publish, command: LightCommand, transition: float) -> Publications:
    if transition:
        command = command._replace(transition=require_transition(transition, _MOST_SECONDS))
    return publish(command)


def read_white_range(config: DiscoveryConfig) -> WhiteRange:
    """Return the range of whites, in kelvin or mired in the config."""
    if _WHITE_FIELDS.isdisjoint(config.values):
        return _USUAL_WHITE
    most = config.integer("max_mireds", 0, least=0, most=_MOST_MIRED)
    least = config.integer("min_mireds", 0, least=0, most=_MOST_MIRED)
    low = config.integer("min_kelvin", _USUAL_WHITE.kelvins[0], least=1, most=_MOST_KELVIN)
    high = config.integer("max_kelvin", _USUAL_WHITE.kelvins[1], least=1, most=_MOST_KELVIN)
    return _white_range(most, least, low, high)


@lru_cache(maxsize=64)
def _white_range(most: int, least: int, low: int, high: int) -> WhiteRange:
    """Return the range of a kind of lamp, of which a house has many."""
    return WhiteRange(
        kelvins=(kelvin_mired(most) if most else low, kelvin_mired(least) if least else high),
        bounds=(
            mired_bounds(most, most)[0] if most else float(low),
            mired_bounds(least, least)[1] if least else float(high),
        ),
    )


_WHITE_FIELDS = frozenset({"max_mireds", "min_mireds", "min_kelvin", "max_kelvin"})
_USUAL_WHITE = WhiteRange((2_000, 6_535), (2_000.0, 6_535.0))
_NO_LEVEL = frozenset({"onoff"})
_PREFERRED = ("hs", "rgb", "rgbw", "rgbww", "xy")
_MOST_MIRED = 1_000_000
_MOST_KELVIN = 1_000_000
_LEAST_KELVIN = 1_000.0
_MOST_WANTED_KELVIN = 40_000.0
