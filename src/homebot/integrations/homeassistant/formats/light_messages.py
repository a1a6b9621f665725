"""Lamps of the schemas ``json`` and ``template``: one message reports the state, one commands it. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/schema_json.py`` and ``schema_template.py``.
"""

import colorsys
from collections.abc import Callable, Mapping

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.lamp import (
    LIGHT_CAPABILITIES,
    MAX_FADE_S,
    PLAIN_MODES,
    LightCommand,
    LightFeatures,
    WhiteRange,
)
from homebot.conventions.light_color import (
    CHANNELS,
    KelvinRange,
    kelvin_mired,
    mired_bounds,
    to_hue_saturation,
    white_kelvin,
)
from homebot.conventions.payload import (
    NO_READINGS,
    Readings,
    clean_text,
    compact_json,
    meaning_reader,
    number_of,
    shown,
    unreadable,
    whole_of,
)
from homebot.conventions.table_codec import json_object
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity
from homebot.integrations.homeassistant.formats.topics import ValueSource


def build_json_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp that uses JSON."""
    light = JsonLight(config)
    entity = Entity(config, "light")
    state_topic = config.state_topic()
    light.lamp.add_to(entity, LIGHT_CAPABILITIES if state_topic else (), light.publish)
    if state_topic:
        entity.read_from(state_topic, light.read)
    entity.add_command_topics(light.command.topic)
    return entity.build()


class JsonLight:
    """Reader and writer of JSON. A colour is read in the reported mode, or in the only mode with a value.

    The same object reports a lamp and commands it, so that a published lamp is read and written by it as well.
    """

    def __init__(self, config: DiscoveryConfig) -> None:
        self.command = config.required_command(template_key="")
        self._scale = config.integer("brightness_scale", 255, least=1)
        self._in_kelvin = config.flag("color_temp_kelvin")
        effects = config.options("effect_list")
        any_effect = config.flag("effect")
        whites = read_white_range(config)
        modes = frozenset(config.options("supported_color_modes"))
        alone = len(modes) > 1 and modes & {"brightness", "onoff"}
        if modes - _MODES or alone or ("white" in modes and not modes & CHANNELS.keys()):
            listed = shown(", ".join(sorted(modes)))
            raise WireError(f"light: supported_color_modes are {listed}, which cannot be combined")
        if not modes:  # one flag for each, as until 2025.2
            colors = frozenset(filter(config.flag, _COLOR_FLAGS))
            modes = colors or frozenset({"brightness" if config.flag("brightness") else "onoff"})
        most = MAX_FADE_S if config.flag("transition", default=True) else 0.0
        self.lamp = LightFeatures(modes, whites, effects, any_effect=any_effect, steps=self._scale, most_seconds=most)

    def publish(self, light: LightCommand) -> Publications:
        """Encode a command."""
        return (self.command.publication(compact_json(self.message(light))),)

    def message(self, light: LightCommand) -> dict[str, object]:
        """Return the object of a command, or of a state."""
        message: dict[str, object] = {"state": "ON" if light.on else "OFF"}
        if light.color:
            message["color"] = dict(zip(CHANNELS[light.mode], light.color, strict=True))
        if light.transition is not None:
            message["transition"] = light.transition
        if (brightness := light.brightness) is not None:
            message["brightness"] = max(round(brightness * self._scale / 255), 1)
        if light.kelvin is not None:
            message["color_temp"] = light.kelvin if self._in_kelvin else kelvin_mired(light.kelvin)
        if light.effect:
            message["effect"] = light.effect
        return message

    def read(self, payload: bytes) -> Readings:
        """Read a state, or a command."""
        message = json_object(payload)
        if message is None:
            return NO_READINGS
        readings = dict(self._read_switch(message))
        lamp = self.lamp
        mode = message["color_mode"] if "color_mode" in message else self._only_mode(message)
        if isinstance(mode, str) and mode in lamp.modes | PLAIN_MODES:
            self._add_color(mode, message, readings)
        if lamp.has_effect:
            effect = message.get("effect")
            if isinstance(effect, str):
                readings["effect"] = clean_text(effect)
        return readings

    def _read_switch(self, message: Mapping[str, object]) -> Readings:
        readings: dict[str, PlainValue] = {}
        state, brightness = message.get("state", ""), message.get("brightness")
        if (state is None or isinstance(state, str)) and state in _STATES:
            readings["on_off"] = _STATES[state]
        else:
            unreadable(state, ("ON", "OFF"))
        if self.lamp.has_level and isinstance(brightness, (int, float)) and 0 < brightness < _HUGE:
            readings["level"] = max(min(brightness * 100 / self._scale, 100.0), 100 / 255)
        elif self.lamp.has_level and brightness != 0:
            unreadable(brightness, "a brightness")
        return readings

    def _only_mode(self, message: Mapping[str, object]) -> str:
        """Return the only mode with a value in the message; empty for none or several."""
        has_white, color = message.get("color_temp") is not None, message.get("color")
        if has_white:
            return "" if isinstance(color, dict) else "color_temp"
        letters = set(color) if isinstance(color, dict) else set()
        fitting = [mode for mode in CHANNELS if mode in self.lamp.modes and letters.issuperset(CHANNELS[mode])]
        return max(fitting, key=lambda mode: len(CHANNELS[mode]), default="")

    def _add_color(self, mode: str, message: Mapping[str, object], readings: dict[str, PlainValue]) -> None:
        if mode == "color_temp":
            kelvin = white_kelvin(number_of(message.get("color_temp")), in_kelvin=self._in_kelvin)
            if kelvin is None:
                return
            readings["color_temperature"] = kelvin
        elif mode in CHANNELS:
            color = _hue_saturation(mode, message.get("color"), self.lamp.white.kelvins)
            if color is None:
                return
            readings["color"] = color
        readings.update(self.lamp.absent_in(mode))


_MODES = PLAIN_MODES | {"color_temp", *CHANNELS}
_STATES: Mapping[str | None, bool | None] = {"ON": True, "OFF": False, None: None}
_HUGE = 10**9
_COLOR_FLAGS = ("color_temp", "hs", "rgb", "xy")
_BOUNDS = {"h": 360.0, "s": 100.0, "x": 1.0, "y": 1.0}


def _hue_saturation(mode: str, color: object, white: KelvinRange) -> tuple[float, ...] | None:
    if not isinstance(color, dict):
        return None
    channels = []
    for letter in CHANNELS[mode]:
        number = number_of(color.get(letter))
        if number is None or not 0 <= number <= _BOUNDS.get(letter, 255.0):
            return None
        channels.append(number if letter in _BOUNDS else float(int(number)))
    return to_hue_saturation(mode, tuple(channels), white)


def read_white_range(config: DiscoveryConfig) -> WhiteRange:
    """Return the range of whites, in kelvin or mired in the config, where lower and upper end may be swapped."""
    if _WHITE_FIELDS.isdisjoint(config.values):
        return _USUAL_WHITE
    most = config.integer("max_mireds", 0, least=0, most=_MAX_WHITE)
    least = config.integer("min_mireds", 0, least=0, most=_MAX_WHITE)
    least, most = sorted((least, most)) if least and most else (least, most)
    ends = zip(("min_kelvin", "max_kelvin"), _USUAL_WHITE.kelvins, strict=True)
    low, high = sorted(config.integer(key, usual, least=1, most=_MAX_WHITE) for key, usual in ends)
    return WhiteRange(
        kelvins=(kelvin_mired(most) if most else low, kelvin_mired(least) if least else high),
        bounds=(
            mired_bounds(most, most)[0] if most else float(low),
            mired_bounds(least, least)[1] if least else float(high),
        ),
    )


_WHITE_FIELDS = frozenset({"max_mireds", "min_mireds", "min_kelvin", "max_kelvin"})
_USUAL_WHITE = WhiteRange((2_000, 6_535), (2_000.0, 6_535.0))
_MAX_WHITE = 1_000_000


def build_template_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp with templates for states and commands."""
    for key in ("command_on_template", "command_off_template"):
        if not config.has(key):
            raise WireError(f"light: {key} is missing; the schema template requires it")
    light = _TemplateLight(config)
    entity = Entity(config, "light")
    light.lamp.add_to(entity, light.add_readers(entity), light.publish)
    entity.add_commands(light.on)
    return entity.build()


_TEMPLATES = ("state", "brightness", "color_temp", "red", "green", "blue", "effect")
_RGB = ("red", "green", "blue")
_WORDS: Mapping[str, bool | None] = {"on": True, "off": False, "None": None}
_BYTE = 255


class _TemplateLight:
    """Reader and writer of a lamp, by one template for each value; a colour needs three."""

    def __init__(self, config: DiscoveryConfig) -> None:
        self.on = config.required_command(template_key="command_on_template")
        self._off = config.required_command(template_key="command_off_template")
        self._in_kelvin = config.flag("color_temp_kelvin")
        modes = set()
        if config.has("color_temp_template"):
            modes.add("color_temp")
        if all(config.has(f"{color}_template") for color in _RGB):
            modes.add("hs")
        if not modes:
            modes.add("brightness" if config.has("brightness_template") else "onoff")
        is_used = any("transition" in config.text(f"command_{state}_template") for state in ("on", "off"))
        effects, most = config.options("effect_list"), MAX_FADE_S if is_used else 0.0
        self.lamp = LightFeatures(frozenset(modes), read_white_range(config), effects, most_seconds=most)
        self._sources: dict[str, ValueSource] = {}
        for key in _TEMPLATES:
            template = f"{key}_template"
            if config.has(template) and (source := config.source("state_topic", template)) is not None:
                self._sources[key] = source

    def publish(self, command: LightCommand) -> Publications:
        variables: dict[str, object] = {"state": command.on}
        if command.brightness is not None:
            variables["brightness"] = command.brightness
        if command.kelvin is not None:
            variables["color_temp"] = command.kelvin if self._in_kelvin else kelvin_mired(command.kelvin)
        if command.color:
            hue, saturation = command.color
            channels = colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1)
            variables |= {color: round(channel * _BYTE) for color, channel in zip(_RGB, channels, strict=True)}
            variables |= {"hue": hue, "sat": saturation}
        if command.effect:
            variables["effect"] = command.effect
        if command.transition is not None:
            variables["transition"] = command.transition
        return (self.on if command.on else self._off).publish(None, variables)

    def add_readers(self, entity: Entity) -> set[str]:
        """Add the readers; return the readable capabilities."""
        rows: tuple[tuple[str, str, Callable[[str], Readings]], ...] = (
            ("on_off", "state", meaning_reader("on_off", _WORDS)),
            ("level", "brightness", _read_level),
            ("color_temperature", "color_temp", self._read_white),
            ("effect", "effect", meaning_reader("effect", {effect: effect for effect in self.lamp.effects})),
        )
        readable = {name for name, key, read in rows if entity.read_text_from(self._sources.get(key), read)}
        red = entity.usable(self._sources.get("red"))
        if red is not None:
            entity.read_from(red.topic, self._read_color)
            readable.add("color")
        return readable

    def _read_white(self, text: str) -> Readings:
        if text == "None":
            return {"color_temperature": None}
        kelvin = white_kelvin(whole_of(text), in_kelvin=self._in_kelvin)
        return unreadable(text, "a white") if kelvin is None else {"color_temperature": kelvin}

    def _read_color(self, payload: bytes) -> Readings:
        texts = [self._sources[color].text(payload) if color in self._sources else None for color in _RGB]
        if texts == ["None"] * len(_RGB):
            return {"color": None}
        channels = [value for text in texts if text and (value := whole_of(text)) is not None]
        if len(channels) != len(_RGB) or not all(0 <= channel <= _BYTE for channel in channels):
            return unreadable(" ".join(filter(None, texts)), "red, green and blue from 0 to 255")
        return {"color": to_hue_saturation("rgb", tuple(channels), self.lamp.white.kelvins)}


def _read_level(text: str) -> Readings:
    brightness = whole_of(text)
    if brightness is None or not 0 <= brightness <= _BYTE:
        return unreadable(text, "0 to 255")
    return {"level": brightness * 100 / _BYTE} if brightness else NO_READINGS
