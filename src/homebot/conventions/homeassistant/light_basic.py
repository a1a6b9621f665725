"""A lamp of schema ``basic``: a topic for each thing that it says or is told. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/schema_basic.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.command_topic import CommandTopic
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.light_basic_state import BasicState, Remembered
from homebot.conventions.homeassistant.light_command import LightCommand, LightFeatures, read_white_range
from homebot.conventions.light_color import CHANNELS, Channels, kelvin_mired
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["build_basic_light"]


def build_basic_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp that has a topic for each thing."""
    commands = _BasicLightCommands(
        command=config.required_command(template_key=""),
        payload_on=config.text("payload_on", "ON"),
        payload_off=config.text("payload_off", "OFF"),
        order=_order(config),
        brightness=config.command("brightness_command_topic", "brightness_command_template"),
        scale=config.integer("brightness_scale", 255, least=1),
        white=config.command("color_temp_command_topic", "color_temp_command_template"),
        in_kelvin=config.flag("color_temp_kelvin"),
        effect=config.command("effect_command_topic", "effect_command_template"),
        colors={
            mode: command
            for mode in CHANNELS
            if (command := config.command(f"{mode}_command_topic", f"{mode}_command_template"))
        },
        remembered=Remembered(),
        assumes=_assumed(config),
    )
    effects = config.options("effect_list") if commands.effect else ()
    has_effect = commands.effect is not None and not effects
    lamp = LightFeatures(commands.modes(), read_white_range(config), commands.publish, effects, any_effect=has_effect)
    entity = Entity(config, "light")
    lamp.add_to(entity, BasicState(lamp, commands.remembered).add_readers(config, entity).__contains__)
    entity.remembers()
    entity.add_commands(
        commands.command, commands.brightness, commands.white, commands.effect, *commands.colors.values()
    )
    return entity.build()


_BYTE = 255
_ORDERS = ("last", "first", "brightness")
_NAMES: Mapping[str, tuple[str, ...]] = {
    "hs": ("hue", "sat"),
    "xy": ("x", "y"),
    "rgb": ("red", "green", "blue"),
    "rgbw": ("red", "green", "blue", "white"),
    "rgbww": ("red", "green", "blue", "cold_white", "warm_white"),
}
"""The names of the channels in templates."""

_DIMMED = ("rgb", "rgbw", "rgbww")
"""Modes whose channels carry the brightness where it has no topic of its own."""


def _order(config: DiscoveryConfig) -> str:
    order = config.text("on_command_type", "last")
    if order not in _ORDERS:
        raise WireError(f"light: on_command_type is {shown(order)}, not last, first or brightness")
    return order


def _assumed(config: DiscoveryConfig) -> frozenset[str]:
    """Return what the lamp does not say, so that what it was told counts: ``brightness`` and colour modes."""
    if config.flag("optimistic"):
        return frozenset({"brightness", *CHANNELS})
    assumed = {mode for mode in CHANNELS if not config.has(f"{mode}_state_topic")}
    own = config.has("brightness_command_topic")
    if not config.has("brightness_state_topic" if own else "rgb_state_topic"):
        assumed.add("brightness")
    return frozenset(assumed)


@dataclass(frozen=True, slots=True)
class _BasicLightCommands:
    """The commands of a lamp: the values on their topics, and that it shall be on before, after, or not at all."""

    command: CommandTopic
    payload_on: str
    payload_off: str
    order: str
    brightness: CommandTopic | None
    scale: int
    white: CommandTopic | None
    in_kelvin: bool
    effect: CommandTopic | None
    colors: Mapping[str, CommandTopic]
    remembered: Remembered
    assumes: frozenset[str]

    def modes(self) -> frozenset[str]:
        """Return the colour modes that the topics amount to."""
        modes = frozenset(self.colors) | ({"color_temp"} if self.white else frozenset())
        return modes or frozenset({"brightness" if self.brightness else "onoff"})

    def publish(self, command: LightCommand) -> tuple[Publication, ...]:
        if not command.on:
            return (self.command.publication(self.payload_off),)
        on = self.command.publication(self.payload_on)
        values = self._values(command)
        if self.order == "first":
            return (on, *values)
        return (*values, on) if self.order == "last" else values

    def _values(self, command: LightCommand) -> tuple[Publication, ...]:
        found: list[Publication] = []
        brightness = command.brightness
        if self.order == "brightness" and brightness is None:
            brightness = self.remembered.brightness or _BYTE
        if command.color:
            full = self.brightness is not None
            found.append(
                self._color(command.mode, command.color, _BYTE if full else self.remembered.brightness or _BYTE)
            )
            if command.mode in self.assumes:
                self.remembered.colors[command.mode] = command.color
        if brightness is not None:
            found += self._brightness(brightness, has_color=bool(command.color))
        if command.kelvin is not None and self.white is not None:
            value = command.kelvin if self.in_kelvin else kelvin_mired(command.kelvin)
            found.append(self.white.publication(value))
        if command.effect and self.effect is not None:
            found.append(self.effect.publication(command.effect))
        return tuple(found)

    def _brightness(self, brightness: int, *, has_color: bool) -> list[Publication]:
        mode = next((one for one in _DIMMED if one in self.colors), "")
        if self.brightness is not None:
            value = max(min(round(brightness / _BYTE * self.scale), self.scale), 1)
            publications = [self.brightness.publication(value)]
        elif mode and not has_color:
            color = self.remembered.colors.get(mode) or (_BYTE,) * len(CHANNELS[mode])
            publications = [self._color(mode, color, brightness)]
        else:
            return []
        if "brightness" in self.assumes:
            self.remembered.brightness = brightness
        return publications

    def _color(self, mode: str, color: Channels, brightness: int) -> Publication:
        if mode in _DIMMED:
            color = tuple(int(channel * brightness / _BYTE) for channel in color)
        variables = dict(zip(_NAMES[mode], color, strict=True))
        return self.colors[mode].publication(",".join(str(channel) for channel in color), variables)
