"""Lamps: their capabilities and their commands, before they are encoded. Pure.

The names of colour modes, and the numbers of brightness and colours, are those of Home Assistant.

Source: Home Assistant core 2025.4, ``components/light/__init__.py``, the service ``light.turn_on``.
"""

from collections.abc import Callable, Collection, Container, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
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
from homebot.conventions.light_color import CHANNELS, Channels, KelvinRange, from_hue_saturation, to_hue_saturation
from homebot.conventions.part_builder import CapabilityFields, PartBuilder
from homebot.conventions.payload import Readings, shown
from homebot.conventions.units import percent_grid
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import to_number

LIGHT_CAPABILITIES = frozenset({"on_off", "level", "color_temperature", "color", "effect"})
"""All capabilities of a lamp."""

PLAIN_MODES = frozenset({"brightness", "onoff", "white"})
"""Colour modes without a value. Lamps report them that list only modes with one."""

MAX_FADE_S = 6_553.0
"""Longest transition in Home Assistant, and in a Zigbee frame."""

MessageT = TypeVar("MessageT")


class LightCommand(NamedTuple):
    """One command to a lamp.

    Attributes:
        level: Percent above 0; None if unchanged.
        white: Its white in kelvin; None if unchanged.
        mode: The channels of *color*; empty if unchanged.
        effect: Its effect; empty if unchanged.
        transition: Seconds of the change; None for the default of the device.
    """

    on: bool
    level: float | None = None
    white: float | None = None
    mode: str = ""
    color: Channels = ()
    effect: str = ""
    transition: float | None = None

    @property
    def brightness(self) -> int | None:
        """The level from 1 to 255."""
        return None if self.level is None else max(1, round(255 * self.level / 100))

    @property
    def percent(self) -> int | None:
        """The level from 1 to 100."""
        return None if self.level is None else max(1, round(self.level))

    @property
    def kelvin(self) -> int | None:
        """The white in whole kelvin, as Home Assistant cuts it off."""
        return None if self.white is None else int(self.white)


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
    """The capabilities of a lamp, and the checks of their values.

    Attributes:
        modes: Its colour modes, with the names of Home Assistant.
        any_effect: Whether it also accepts unlisted effects.
        is_dimmable: Whether lamps with colours have a brightness.
        only_in_bounds: Whether a white beyond its bounds is refused, rather than left to the device.
        most_seconds: The longest transition; a longer one is refused. 0 if it takes none: any is left out.
        steps: The number of brightnesses.
        color_mode: The channels of commanded colours; empty for a lamp without colours.
    """

    modes: frozenset[str]
    white: WhiteRange
    effects: tuple[str, ...] = ()
    any_effect: bool = False
    is_dimmable: bool = True
    only_in_bounds: bool = False
    most_seconds: float = MAX_FADE_S
    steps: int = 255
    has_level: bool = field(init=False)
    has_white: bool = field(init=False)
    has_effect: bool = field(init=False)
    color_mode: str = field(init=False)
    _grid: tuple[float, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.has_level = self.is_dimmable and not self.modes <= _NO_LEVEL
        self.has_white = "color_temp" in self.modes
        self.has_effect = self.any_effect or bool(self.effects)
        self._grid = percent_grid(self.steps)
        self.color_mode = next((mode for mode in _PREFERRED if mode in self.modes), "")

    def abilities(self) -> dict[str, CapabilityFields]:
        """Return the bounds and the options of its capabilities, by name."""
        abilities: dict[str, CapabilityFields] = {"on_off": {}}
        if self.has_level:
            abilities["level"] = {"grid": self._grid}
        if self.has_white:
            abilities["color_temperature"] = {"bounds": self.white.bounds}
        if self.color_mode:
            abilities["color"] = {}
        if self.has_effect:
            abilities["effect"] = {"options": self.effects}
        return abilities

    def absent_in(self, mode: str) -> Readings:
        """Return the colours that the lamp does not have in *mode*, as absent: both in one without a value."""
        readings: dict[str, PlainValue] = {}
        if self.has_white and mode != "color_temp":
            readings["color_temperature"] = None
        if self.color_mode and mode not in CHANNELS:
            readings["color"] = None
        return readings

    def add_to(self, part: PartBuilder[MessageT], readable: Container[str], publish: Publish) -> None:
        """Add the capabilities to *part*; *readable* ones are reported, and *publish* encodes a command."""
        part.joint = partial(self._write_several, publish)
        part.fades = self.most_seconds > 0
        for name, fields in self.abilities().items():
            part.add_capability(name, readable=name in readable, writer=partial(self._write, publish, name), **fields)

    def command(self, capability: str, value: PlainValue, transition: float = 0.0) -> LightCommand:
        """Return the command that sets *capability*.

        Raises:
            RefusedError: The lamp lacks the capability, or the value or the transition is out of its bounds.
        """
        names = self.abilities()
        if capability not in names:
            raise RefusedError(shown(capability), f"this part takes {', '.join(names)}")
        commands: Mapping[str, Callable[[PlainValue], LightCommand]] = {
            "on_off": _switch,
            "level": _dim,
            "color_temperature": self._set_white,
            "color": self._set_color,
            "effect": self._set_effect,
        }
        command = commands[capability](value)
        if transition and self.most_seconds:
            return command._replace(transition=require_transition(transition, self.most_seconds))
        return command

    def joint_command(self, values: Mapping[str, PlainValue], transition: float = 0.0) -> LightCommand:
        """Return the one command that sets all *values*; raise as :meth:`command`."""
        joint: LightCommand | None = None
        for name, value in values.items():
            command = self.command(name, value, transition)
            if joint is None or not command.on:
                joint = command
            elif joint.on:
                set_here = {key: value for key, value in command._asdict().items() if value not in (None, "", ())}
                joint = joint._replace(**set_here)
        assert joint is not None, "a command sets something"  # noqa: S101 - for the type checker
        return joint

    def _write_several(
        self, publish: Publish, writers: Mapping[str, Writer], values: Mapping[str, PlainValue], transition: float
    ) -> tuple[Publications, Collection[str]]:
        own = {name: value for name, value in values.items() if name in LIGHT_CAPABILITIES}
        first, value = next(iter(values.items()))
        if first not in own:
            return writers[first](value, transition), (first,)
        return publish(self.joint_command(own, transition)), own

    def _write(self, publish: Publish, capability: str, value: PlainValue, transition: float) -> Publications:
        return publish(self.command(capability, value, transition))

    def _set_white(self, value: PlainValue) -> LightCommand:
        bounds = self.white.bounds if self.only_in_bounds else (*self.white.bounds, *_ANY_KELVIN)
        return LightCommand(on=True, white=require_number("color_temperature", value, min(bounds), max(bounds), "K"))

    def _set_color(self, value: PlainValue) -> LightCommand:
        color = from_hue_saturation(self.color_mode, *require_color(value), self.white.kelvins)
        return LightCommand(on=True, mode=self.color_mode, color=color)

    def _set_effect(self, value: PlainValue) -> LightCommand:
        if self.effects or not isinstance(value, str):
            require_option("effect", value, self.effects)
        return LightCommand(on=True, effect=str(value))


def _switch(value: PlainValue) -> LightCommand:
    return LightCommand(on=require_bool("on_off", value))


def _dim(value: PlainValue) -> LightCommand:
    """Return the command of a brightness in percent; only 0 switches the lamp off."""
    percent = require_number("level", value, 0, 100, "%")
    return LightCommand(on=True, level=percent) if percent else LightCommand(on=False)


def read_lamp(fields: Mapping[str, object], on_key: str, level_key: str) -> Readings:
    """Return switch and level of a lamp, as far as *fields* have them."""
    readings: dict[str, PlainValue] = {}
    if isinstance(on := fields.get(on_key), bool):
        readings["on_off"] = on
    level = to_number(fields.get(level_key))
    if level is not None and 0 <= level <= 100:
        readings["level"] = level
    return readings


def read_rgb(values: Sequence[object]) -> tuple[float, float] | None:
    """Return hue and saturation of three channels from 0 to 255; None for other values."""
    channels = tuple(channel for channel in map(to_number, values) if channel is not None and 0 <= channel <= 255)
    if len(values) != _RGB or len(channels) != _RGB:
        return None
    return to_hue_saturation("rgb", channels, _ANY_WHITE)


_NO_LEVEL = frozenset({"onoff"})
_PREFERRED = ("hs", "rgb", "rgbw", "rgbww", "xy")
_ANY_KELVIN = (1_000.0, 40_000.0)
_RGB = 3
_ANY_WHITE = (2700, 6500)  # without meaning for red, green and blue
