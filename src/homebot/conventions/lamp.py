"""Lamps with the colour modes of Home Assistant: their capabilities and their commands, before they are encoded. Pure.

Source: Home Assistant core 2025.4, ``components/light/__init__.py``, the service ``light.turn_on``.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias, TypeVar

from homebot.conventions.command_values import (
    Writer,
    require_bool,
    require_color,
    require_number,
    require_option,
    require_transition,
)
from homebot.conventions.description import Publications
from homebot.conventions.light_color import Channels, KelvinRange, from_hue_saturation
from homebot.conventions.part_builder import PartBuilder
from homebot.devices.value import PlainValue

__all__ = ["LightCommand", "LightFeatures", "Publish", "WhiteRange"]

_MOST_SECONDS = 6_553.0
"""Longest transition in Home Assistant, and in a Zigbee frame."""

MessageT = TypeVar("MessageT")


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
        kelvins: Warmest and coldest, for calculations of channels of white.
        bounds: The lowest and the highest accepted kelvin; empty for unknown ones.
    """

    kelvins: KelvinRange
    bounds: tuple[float, ...]


@dataclass(slots=True)
class LightFeatures:
    """The capabilities of a lamp, and their values.

    Attributes:
        modes: Its colour modes, with the names of Home Assistant.
        any_effect: Whether it also accepts unlisted effects.
        is_dimmable: Whether lamps with colours have a brightness.
        has_level: Whether its brightness can be set.
        has_white: Whether its colour temperature can be set.
        has_effect: Whether it has effects.
        color_mode: The channels of commanded colours; empty for a lamp without colours.
    """

    modes: frozenset[str]
    white: WhiteRange
    effects: tuple[str, ...] = ()
    any_effect: bool = False
    is_dimmable: bool = True
    has_level: bool = field(init=False)
    has_white: bool = field(init=False)
    has_effect: bool = field(init=False)
    color_mode: str = field(init=False)

    def __post_init__(self) -> None:
        self.has_level = self.is_dimmable and not self.modes <= _NO_LEVEL
        self.has_white = "color_temp" in self.modes
        self.has_effect = self.any_effect or bool(self.effects)
        self.color_mode = next((mode for mode in _PREFERRED if mode in self.modes), "")

    def add_to(self, part: PartBuilder[MessageT], readable: Container[str], publish: Publish) -> None:
        """Add the capabilities to *part*; *readable* ones are reported, and *publish* encodes a command."""
        rows: tuple[tuple[str, bool, Callable[[PlainValue], LightCommand]], ...] = (
            ("on_off", True, lambda value: LightCommand(on=require_bool("on_off", value))),
            ("level", self.has_level, _dim),
            ("color_temperature", self.has_white, self._set_white),
            ("color", bool(self.color_mode), self._set_color),
            ("effect", self.has_effect, self._set_effect),
        )
        bounds, options = {"color_temperature": self.white.bounds}, {"effect": self.effects}
        for name, is_present, command_of in rows:
            if is_present:
                part.add_capability(
                    name,
                    readable=name in readable,
                    writer=_writer(command_of, publish),
                    bounds=bounds.get(name, ()),
                    options=options.get(name, ()),
                )

    def _set_white(self, value: PlainValue) -> LightCommand:
        bounds = (*self.white.bounds, *_ANY_KELVIN)
        return LightCommand(
            on=True, kelvin=int(require_number("color_temperature", value, min(bounds), max(bounds), "K"))
        )

    def _set_color(self, value: PlainValue) -> LightCommand:
        color = from_hue_saturation(self.color_mode, *require_color(value), self.white.kelvins)
        return LightCommand(on=True, mode=self.color_mode, color=color)

    def _set_effect(self, value: PlainValue) -> LightCommand:
        if self.effects or not isinstance(value, str):
            require_option("effect", value, self.effects)
        return LightCommand(on=True, effect=str(value))


def _dim(value: PlainValue) -> LightCommand:
    """Return the command of a brightness in percent; only 0 switches the lamp off."""
    percent = require_number("level", value, 0, 100, "%")
    return LightCommand(on=True, brightness=max(1, round(255 * percent / 100))) if percent else LightCommand(on=False)


def _writer(command_of: Callable[[PlainValue], LightCommand], publish: Publish) -> Writer:
    def write(value: PlainValue, transition: float) -> Publications:
        command = command_of(value)
        if transition:
            command = command._replace(transition=require_transition(transition, _MOST_SECONDS))
        return publish(command)

    return write


_NO_LEVEL = frozenset({"onoff"})
_PREFERRED = ("hs", "rgb", "rgbw", "rgbww", "xy")
_ANY_KELVIN = (1_000.0, 40_000.0)
