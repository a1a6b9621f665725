"""A lamp of schema ``template``: templates read its state, two templates make its commands. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/schema_template.py``.
"""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.light_json import read_white_range
from homebot.conventions.homeassistant.topics import CommandTopic, StateMessage, ValueSource
from homebot.conventions.lamp import LightCommand, LightFeatures
from homebot.conventions.light_color import kelvin_mired, to_hue_saturation, white_kelvin
from homebot.conventions.payload import NO_READINGS, Readings, whole_of
from homebot.errors import WireError

__all__ = ["build_template_light"]


def build_template_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp with templates for states and commands."""
    for key in ("command_on_template", "command_off_template"):
        if not config.has(key):
            raise WireError(f"light: {key} is missing; the schema template requires it")
    on = config.required_command(template_key="command_on_template")
    off = config.required_command(template_key="command_off_template")
    in_kelvin = config.flag("color_temp_kelvin")
    lamp = LightFeatures(
        modes=_modes(config),
        white=read_white_range(config),
        effects=config.options("effect_list"),
    )
    sources = {key: source for key in _TEMPLATES if (source := _source(config, key)) is not None}
    entity = Entity(config, "light")
    reader = _TemplateLightReader(sources, lamp, in_kelvin)
    readable = {
        name
        for name, key, read in (
            ("on_off", "state", reader.state),
            ("level", "brightness", reader.level),
            ("color_temperature", "color_temp", reader.white),
            ("color", "red", reader.color),
            ("effect", "effect", reader.effect),
        )
        if entity.read_message_from(sources.get(key), read)
    }
    lamp.add_to(entity, readable, partial(_publish, on, off, in_kelvin))
    entity.add_commands(on)
    return entity.build()


_TEMPLATES = ("state", "brightness", "color_temp", "red", "green", "blue", "effect")
_RGB = ("red", "green", "blue")
_STATES: Mapping[str, bool | None] = {"on": True, "off": False, "None": None}
_BYTE = 255


def _source(config: DiscoveryConfig, key: str) -> ValueSource | None:
    template_key = f"{key}_template"
    return config.source("state_topic", template_key) if config.has(template_key) else None


def _modes(config: DiscoveryConfig) -> frozenset[str]:
    modes = set()
    if config.has("color_temp_template"):
        modes.add("color_temp")
    if all(config.has(f"{color}_template") for color in _RGB):
        modes.add("hs")
    if not modes:
        modes.add("brightness" if config.has("brightness_template") else "onoff")
    return frozenset(modes)


def _publish(on: CommandTopic, off: CommandTopic, in_kelvin: bool, command: LightCommand) -> Publications:  # noqa: FBT001 - bound once, above
    variables: dict[str, object] = {"state": command.on}
    if command.brightness is not None:
        variables["brightness"] = command.brightness
    if command.kelvin is not None:
        variables["color_temp"] = command.kelvin if in_kelvin else kelvin_mired(command.kelvin)
    if command.color:
        hue, saturation = command.color
        channels = colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1)
        variables |= {color: round(one * _BYTE) for color, one in zip(_RGB, channels, strict=True)}
        variables |= {"hue": hue, "sat": saturation}
    if command.effect:
        variables["effect"] = command.effect
    if command.transition is not None:
        variables["transition"] = command.transition
    return ((on if command.on else off).publication(None, variables),)


@dataclass(frozen=True, slots=True)
class _TemplateLightReader:
    """Reader of a lamp's state, one template at a time; a colour needs three."""

    sources: Mapping[str, ValueSource]
    lamp: LightFeatures
    in_kelvin: bool

    def state(self, _message: StateMessage, text: str) -> Readings:
        return {"on_off": _STATES[text]} if text in _STATES else NO_READINGS

    def level(self, _message: StateMessage, text: str) -> Readings:
        brightness = whole_of(text) or 0
        return {"level": brightness * 100 / _BYTE} if 0 < brightness <= _BYTE else NO_READINGS

    def white(self, _message: StateMessage, text: str) -> Readings:
        if text == "None":
            return {"color_temperature": None}
        kelvin = white_kelvin(whole_of(text), in_kelvin=self.in_kelvin)
        return NO_READINGS if kelvin is None else {"color_temperature": kelvin}

    def color(self, message: StateMessage, red: str) -> Readings:
        green, blue = (self.sources[one].text(message) if one in self.sources else None for one in ("green", "blue"))
        if (red, green, blue) == ("None", "None", "None"):
            return {"color": None}
        channels = [value for one in (red, green, blue) if one and (value := whole_of(one)) is not None]
        if len(channels) != len(_RGB) or not all(0 <= one <= _BYTE for one in channels):
            return NO_READINGS
        return {"color": to_hue_saturation("rgb", tuple(channels), self.lamp.white.kelvins)}

    def effect(self, _message: StateMessage, text: str) -> Readings:
        return {"effect": text} if text in self.lamp.effects else NO_READINGS
