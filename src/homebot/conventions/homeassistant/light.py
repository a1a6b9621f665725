"""The component ``light``, and its schema ``basic``: a topic for each value that a lamp reports or takes. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/__init__.py`` and ``schema_basic.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from homebot.conventions.description import DescribedPart, Publication, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.light_messages import build_json_light, build_template_light, read_white_range
from homebot.conventions.homeassistant.topics import CommandTopic, ValueSource
from homebot.conventions.lamp import LightCommand, LightFeatures
from homebot.conventions.light_color import CHANNELS, Channels, kelvin_mired, to_hue_saturation, white_kelvin
from homebot.conventions.payload import (
    NO_READINGS,
    Readings,
    clean_text,
    meaning_reader,
    number_of,
    numbers_of,
    shown,
    whole_of,
)
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["build_light"]

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

_MOST = {"hs": (360, 100), "xy": (1, 1)}
_DIMMED = ("rgb", "rgbw", "rgbww")
"""Modes with the brightness in their channels, unless it has a topic of its own."""


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    build = _SCHEMAS.get(config.text("schema", "basic").lower())
    if build is None:
        raise WireError(f"light: schema is {shown(config.text('schema'))}, not basic, json or template")
    return build(config)


@dataclass(slots=True)
class _BasicState:
    """Reader of the state topics of a lamp, and its last state, for commands that combine brightness and colour.

    Attributes:
        brightness: 1 to 255; None before the first report.
        colors: Its colour at full brightness by mode.
        mode: The last reported mode; None before the first report.
        reported: The last reported value of each mode.
    """

    lamp: LightFeatures
    brightness: int | None = None
    colors: dict[str, Channels] = field(default_factory=dict)
    has_mode: bool = False
    mode: str | None = None
    reported: dict[str, PlainValue] = field(default_factory=dict)

    def add_readers(self, config: DiscoveryConfig, entity: Entity) -> frozenset[str]:
        """Add readers of all state topics to *entity*; return the readable capabilities."""
        lamp, own_level = self.lamp, bool(config.state_topic("brightness_state_topic"))
        states = {config.text("payload_off", "OFF"): False, config.text("payload_on", "ON"): True, "None": None}
        level = partial(self._level, config.integer("brightness_scale", _BYTE, least=1))
        rows: list[tuple[str, str, bool, Callable[[str], Readings]]] = [
            ("on_off", "state", True, meaning_reader("on_off", states)),
            ("level", "brightness_state", lamp.has_level, level),
            ("", "color_mode_state", True, self._mode),
            (
                "color_temperature",
                "color_temp_state",
                lamp.has_white,
                partial(self._white, config.flag("color_temp_kelvin")),
            ),
            *(
                ("color", f"{mode}_state", mode in lamp.modes, partial(self._color, mode, own_level or mode in _MOST))
                for mode in CHANNELS
            ),
            (
                "effect",
                "effect_state",
                lamp.has_effect,
                lambda text: {"effect": clean_text(text)} if text else NO_READINGS,
            ),
        ]
        readable = set()
        for capability, name, is_present, read in rows:
            if is_present and entity.read_text_from(_source(config, name), read):
                readable.add(capability)
                if capability == "color" and not own_level and name.removesuffix("_state") in _DIMMED:
                    readable.add("level")
        self.has_mode = "" in readable
        return frozenset(readable)

    def _white(self, in_kelvin: bool, text: str) -> Readings:  # noqa: FBT001 - bound once, above
        kelvin = white_kelvin(whole_of(text), in_kelvin=in_kelvin)
        if kelvin is None:
            return NO_READINGS
        return self._report("color_temp", kelvin)

    def _mode(self, text: str) -> Readings:
        """Read the mode; the values of the modes come before or after it."""
        if text not in self.lamp.modes:
            return NO_READINGS
        self.mode = text
        reported = self.reported.get(text)
        return NO_READINGS if reported is None else self._report(text, reported)

    def _report(self, mode: str, value: PlainValue) -> Readings:
        """Record the value of a colour mode; it is effective in the reported mode, or without one."""
        self.reported[mode] = value
        if self.has_mode and self.mode not in (None, mode):
            return NO_READINGS
        if mode == "color_temp":
            return {"color_temperature": value} | ({"color": None} if self.lamp.color_mode else {})
        return {"color": value} | ({"color_temperature": None} if self.lamp.has_white else {})

    def _level(self, scale: int, text: str) -> Readings:
        value = number_of(text) or 0
        if value <= 0:
            return NO_READINGS
        self.brightness = max(round(min(value / scale, 1) * _BYTE), 1)
        return {"level": self.brightness * 100 / _BYTE}

    def _color(self, mode: str, own_level: bool, text: str) -> Readings:  # noqa: FBT001 - bound once, above
        """Read a colour, and the brightness of a lamp without a topic for it."""
        channels = numbers_of(text, len(CHANNELS[mode]))
        most = _MOST.get(mode, (_BYTE,) * len(CHANNELS[mode]))
        if channels is None or not all(0 <= one <= limit for one, limit in zip(channels, most, strict=True)):
            return NO_READINGS
        found: dict[str, PlainValue] = {}
        if not own_level:
            brightness = int(max(channels))
            if not brightness:
                return NO_READINGS
            channels = tuple(min(round(one / brightness * _BYTE), _BYTE) for one in channels)
            self.brightness = brightness
            found["level"] = brightness * 100 / _BYTE
        self.colors[mode] = channels
        return {**found, **self._report(mode, to_hue_saturation(mode, channels, self.lamp.white.kelvins))}


def _build_basic_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp with a topic for each value."""
    brightness, white, effect = (config.command_of(name) for name in ("brightness", "color_temp", "effect"))
    colors = {mode: command for mode in CHANNELS if (command := config.command_of(mode))}
    modes = frozenset({*colors, *(["color_temp"] if white else [])} or {"brightness" if brightness else "onoff"})
    effects = config.options("effect_list") if effect else ()
    lamp = LightFeatures(modes, read_white_range(config), effects, any_effect=effect is not None and not effects)
    state = _BasicState(lamp)
    commands = _BasicLightCommands(
        command=config.required_command(template_key=""),
        payloads=config.on_off_payloads(),
        order=_order(config),
        brightness=brightness,
        scale=config.integer("brightness_scale", _BYTE, least=1),
        white=white,
        in_kelvin=config.flag("color_temp_kelvin"),
        effect=effect,
        colors=colors,
        state=state,
        assumes=_assumed(config),
    )
    entity = Entity(config, "light")
    lamp.add_to(entity, state.add_readers(config, entity), commands.publish)
    entity.remembers()
    entity.add_commands(commands.command, brightness, white, effect, *colors.values())
    return entity.build()


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


def _assumed(config: DiscoveryConfig) -> frozenset[str]:
    """Return the unreported values, for which the last command is assumed: ``brightness`` and colour modes."""
    if config.flag("optimistic"):
        return frozenset({"brightness", *CHANNELS})
    assumed = {mode for mode in CHANNELS if not config.has(f"{mode}_state_topic")}
    own = config.has("brightness_command_topic")
    if not config.has("brightness_state_topic" if own else "rgb_state_topic"):
        assumed.add("brightness")
    return frozenset(assumed)


@dataclass(frozen=True, slots=True)
class _BasicLightCommands:
    """Writer of a lamp: the values on their topics, and its switch before, after, or not at all."""

    command: CommandTopic
    payloads: Mapping[bool, str]
    order: str
    brightness: CommandTopic | None
    scale: int
    white: CommandTopic | None
    in_kelvin: bool
    effect: CommandTopic | None
    colors: Mapping[str, CommandTopic]
    state: _BasicState
    assumes: frozenset[str]

    def publish(self, command: LightCommand) -> Publications:
        if not command.on:
            return self.command.publish(self.payloads[False])
        on = self.command.publication(self.payloads[True])
        values = self._values(command)
        if self.order == "first":
            return (on, *values)
        return (*values, on) if self.order == "last" else values

    def _values(self, command: LightCommand) -> Publications:
        found: list[Publication] = []
        brightness = command.brightness
        if self.order == "brightness" and brightness is None:
            brightness = self.state.brightness or _BYTE
        if command.color:
            found.append(self._set_color(command.mode, command.color))
        if brightness is not None:
            found += self._brightness(brightness, has_color=bool(command.color))
        if command.kelvin is not None and self.white is not None:
            value = command.kelvin if self.in_kelvin else kelvin_mired(command.kelvin)
            found.append(self.white.publication(value))
        if command.effect and self.effect is not None:
            found.append(self.effect.publication(command.effect))
        return tuple(found)

    def _set_color(self, mode: str, color: Channels) -> Publication:
        brightness = _BYTE if self.brightness is not None else self.state.brightness or _BYTE
        publication = self._color(mode, color, brightness)
        if mode in self.assumes:
            self.state.colors[mode] = color
        return publication

    def _brightness(self, brightness: int, *, has_color: bool) -> list[Publication]:
        mode = next((one for one in _DIMMED if one in self.colors), "")
        if self.brightness is not None:
            value = max(min(round(brightness / _BYTE * self.scale), self.scale), 1)
            publications = [self.brightness.publication(value)]
        elif mode and not has_color:
            color = self.state.colors.get(mode) or (_BYTE,) * len(CHANNELS[mode])
            publications = [self._color(mode, color, brightness)]
        else:
            return []
        if "brightness" in self.assumes:
            self.state.brightness = brightness
        return publications

    def _color(self, mode: str, color: Channels, brightness: int) -> Publication:
        if mode in _DIMMED:
            color = tuple(int(channel * brightness / _BYTE) for channel in color)
        variables = dict(zip(_NAMES[mode], color, strict=True))
        return self.colors[mode].publication(",".join(str(channel) for channel in color), variables)


_SCHEMAS: Mapping[str, Callable[[DiscoveryConfig], DescribedPart]] = {
    "basic": _build_basic_light,
    "json": build_json_light,
    "template": build_template_light,
}
