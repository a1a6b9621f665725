"""The component ``light``, and its schema ``basic``: a topic for each value that a lamp reports or takes. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/__init__.py`` and ``schema_basic.py``.
"""

from collections.abc import Callable, Mapping
from functools import partial

from homebot.conventions.description import DescribedPart, Publication, Publications
from homebot.conventions.lamp import PLAIN_MODES, LightCommand, LightFeatures
from homebot.conventions.light_color import CHANNELS, Channels, kelvin_mired, to_hue_saturation, white_kelvin
from homebot.conventions.payload import (
    NO_READINGS,
    Readings,
    clean_text,
    meaning_reader,
    number_of,
    numbers_of,
    shown,
    unreadable,
    whole_of,
)
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity
from homebot.integrations.homeassistant.formats.light_messages import (
    build_json_light,
    build_template_light,
    read_white_range,
)
from homebot.integrations.homeassistant.formats.topics import ValueSource

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

_CHANNEL_ENDS = {"hs": (360, 100), "xy": (1, 1)}
_DIMMED = ("rgb", "rgbw", "rgbww")
"""Modes with the brightness in their channels, unless it has a topic of its own."""


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    build = _SCHEMAS.get(config.text("schema", "basic").lower())
    if build is None:
        raise WireError(f"light: schema is {shown(config.text('schema'))}, not basic, json or template")
    return build(config)


class _BasicLight:
    """Reader and writer of a lamp with a topic for each value; commands combine its last brightness and colour.

    These are the last reported or commanded ones: a command of several settings is written setting by setting.

    Attributes:
        lamp: Its capabilities.
        commands: The topics of its commands.
    """

    def __init__(self, config: DiscoveryConfig) -> None:
        self._level_command, self._white_command, self._effect_command = (
            config.command_of(name) for name in ("brightness", "color_temp", "effect")
        )
        self._color_commands = {mode: command for mode in CHANNELS if (command := config.command_of(mode))}
        modes = {*self._color_commands, *(["color_temp"] if self._white_command else [])}
        modes = modes or {"brightness" if self._level_command else "onoff"}
        effects = config.options("effect_list") if self._effect_command else ()
        any_effect = self._effect_command is not None and not effects
        self._scale = config.integer("brightness_scale", _BYTE, least=1)
        steps = self._scale if self._level_command else _BYTE
        whites = read_white_range(config)
        self.lamp = LightFeatures(
            frozenset(modes), whites, effects, any_effect=any_effect, steps=steps, most_seconds=0.0
        )
        self._command = config.required_command(template_key="")
        self._payloads = config.on_off_payloads()
        self._order = _order(config)
        self._in_kelvin = config.flag("color_temp_kelvin")
        self._own_level = bool(config.state_topic("brightness_state_topic"))
        self._has_mode = False
        self._mode: str | None = None
        self._reported: dict[str, PlainValue] = {}
        self._brightness: int | None = None
        self._colors: dict[str, Channels] = {}  # at full brightness
        others = (self._level_command, self._white_command, self._effect_command)
        self.commands = (self._command, *others, *self._color_commands.values())

    def add_readers(self, config: DiscoveryConfig, entity: Entity) -> frozenset[str]:
        """Add readers of all state topics to *entity*; return the readable capabilities."""
        lamp = self.lamp
        states = {self._payloads[False]: False, self._payloads[True]: True, "None": None}
        rows: list[tuple[str, str, bool, Callable[[str], Readings]]] = [
            ("on_off", "state", True, meaning_reader("on_off", states)),
            ("level", "brightness_state", lamp.has_level, self._read_level),
            ("", "color_mode_state", True, self._read_mode),
            ("color_temperature", "color_temp_state", lamp.has_white, self._read_white),
            *(("color", f"{mode}_state", mode in lamp.modes, partial(self._read_color, mode)) for mode in CHANNELS),
            ("effect", "effect_state", lamp.has_effect, _read_effect),
        ]
        readable = set()
        for capability, name, is_present, read in rows:
            if is_present and entity.read_text_from(_source(config, name), read):
                readable.add(capability)
                if capability == "color" and not self._own_level and name.removesuffix("_state") in _DIMMED:
                    readable.add("level")
        self._has_mode = "" in readable
        return frozenset(readable)

    def _read_white(self, text: str) -> Readings:
        kelvin = white_kelvin(whole_of(text), in_kelvin=self._in_kelvin)
        return unreadable(text, "a white") if kelvin is None else self._report("color_temp", kelvin)

    def _read_mode(self, text: str) -> Readings:
        """Read the mode; the values of the modes come before or after it."""
        if text not in self.lamp.modes | PLAIN_MODES:
            return NO_READINGS
        self._mode = text
        if text in PLAIN_MODES:
            return self.lamp.absent_in(text)
        reported = self._reported.get(text)
        return NO_READINGS if reported is None else self._report(text, reported)

    def _report(self, mode: str, value: PlainValue) -> Readings:
        """Record the value of a colour mode; it is effective in the reported mode, or without one."""
        self._reported[mode] = value
        if self._has_mode and self._mode not in (None, mode):
            return NO_READINGS
        name = "color_temperature" if mode == "color_temp" else "color"
        return {name: value, **self.lamp.absent_in(mode)}

    def _read_level(self, text: str) -> Readings:
        value = number_of(text)
        if value is None or value <= 0:
            return unreadable(text, "a brightness") if value is None else NO_READINGS
        level = max(min(value * 100 / self._scale, 100.0), 100 / _BYTE)
        self._brightness = round(level * _BYTE / 100)
        return {"level": level}

    def _read_color(self, mode: str, text: str) -> Readings:
        """Read a colour, and the brightness of a lamp without a topic for it."""
        channels = numbers_of(text, len(CHANNELS[mode]))
        most = _CHANNEL_ENDS.get(mode, (_BYTE,) * len(CHANNELS[mode]))
        if channels is None or not all(0 <= channel <= limit for channel, limit in zip(channels, most, strict=True)):
            return unreadable(text, f"{mode} with commas")
        readings: dict[str, PlainValue] = {}
        if not self._own_level and mode in _DIMMED:
            brightness = int(max(channels))
            if not brightness:
                return NO_READINGS
            channels = tuple(min(round(channel / brightness * _BYTE), _BYTE) for channel in channels)
            self._brightness = brightness
            readings["level"] = brightness * 100 / _BYTE
        self._colors[mode] = channels
        return {**readings, **self._report(mode, to_hue_saturation(mode, channels, self.lamp.white.kelvins))}

    def publish(self, command: LightCommand) -> Publications:
        """Encode a command: the values on their topics, and its switch before, after, or not at all."""
        if not command.on:
            return self._command.publish(self._payloads[False])
        on = self._command.publication(self._payloads[True])
        values = self._values(command)
        if self._order == "first":
            return (on, *values)
        return (*values, on) if self._order == "last" else values

    def _values(self, command: LightCommand) -> Publications:
        publications: list[Publication] = []
        brightness = command.brightness
        if brightness is None and self._order == "brightness":  # which is what turns the lamp on
            brightness = self._brightness or _BYTE
        if command.color:
            full = _BYTE if self._level_command is not None else self._brightness or _BYTE
            self._colors[command.mode] = command.color
            publications.append(self._color(command.mode, command.color, full))
        if brightness is not None:
            publications += self._dim(brightness, has_color=bool(command.color))
        if command.kelvin is not None and self._white_command is not None:
            value = command.kelvin if self._in_kelvin else kelvin_mired(command.kelvin)
            publications.append(self._white_command.publication(value))
        if command.effect and self._effect_command is not None:
            publications.append(self._effect_command.publication(command.effect))
        return tuple(publications)

    def _dim(self, brightness: int, *, has_color: bool) -> list[Publication]:
        mode = next((mode_known for mode_known in _DIMMED if mode_known in self._color_commands), "")
        if self._level_command is not None:
            value = max(min(round(brightness / _BYTE * self._scale), self._scale), 1)
            publications = [self._level_command.publication(value)]
        elif mode and not has_color:
            color = self._colors.get(mode) or (_BYTE,) * len(CHANNELS[mode])
            publications = [self._color(mode, color, brightness)]
        else:
            return []
        self._brightness = brightness
        return publications

    def _color(self, mode: str, color: Channels, brightness: int) -> Publication:
        if mode in _DIMMED:
            color = tuple(int(channel * brightness / _BYTE) for channel in color)
        variables = dict(zip(_NAMES[mode], color, strict=True))
        return self._color_commands[mode].publication(",".join(str(channel) for channel in color), variables)


def _build_basic_light(config: DiscoveryConfig) -> DescribedPart:
    light = _BasicLight(config)
    entity = Entity(config, "light")
    light.lamp.add_to(entity, light.add_readers(config, entity), light.publish)
    entity.remembers()
    entity.add_commands(*light.commands)
    return entity.build()


def _read_effect(text: str) -> Readings:
    return {"effect": clean_text(text)} if text else NO_READINGS


def _source(config: DiscoveryConfig, name: str) -> ValueSource | None:
    """Return the source of *name*; ``value_template`` is that of the state until 2022.2, as of old Tasmota."""
    template = "state_value_template" if name == "state" else f"{name.removesuffix('_state')}_value_template"
    source = config.source(f"{name}_topic", template if name != "state" or config.has(template) else "value_template")
    return source.without_payload() if source and name != "state" else source


def _order(config: DiscoveryConfig) -> str:
    order = config.text("on_command_type", "last")
    if order not in _ORDERS:
        raise WireError(f"light: on_command_type is {shown(order)}, not last, first or brightness")
    return order


_SCHEMAS: Mapping[str, Callable[[DiscoveryConfig], DescribedPart]] = {
    "basic": _build_basic_light,
    "json": build_json_light,
    "template": build_template_light,
}
