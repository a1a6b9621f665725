"""State of a lamp of schema ``basic``, each value on its own topic. Pure: equal messages give an equal state.

Source: Home Assistant core 2025.4, ``components/mqtt/light/schema_basic.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.light_command import LightFeatures
from homebot.conventions.homeassistant.value_parsing import number_of, numbers_of, whole_of
from homebot.conventions.light_color import CHANNELS, Channels, to_hue_saturation, white_kelvin
from homebot.conventions.payload import clean_text
from homebot.devices.value import PlainValue

__all__ = ["BasicState", "Remembered"]

_BYTE = 255


@dataclass(slots=True)
class Remembered:
    """The last state of a lamp, for commands that need it: some are made of brightness and colour together.

    Attributes:
        brightness: 1 to 255; None before the first word.
        colors: Its colour at full brightness by mode.
        has_mode: Whether it says its colour mode.
        mode: The mode that it said last; None before the first word.
        reported: What it said last in each mode, as it is reported.
    """

    brightness: int | None = None
    colors: dict[str, Channels] = field(default_factory=dict)
    has_mode: bool = False
    mode: str | None = None
    reported: dict[str, PlainValue] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class BasicState:
    """Reads what the lamp says.

    Attributes:
        lamp: What it can do.
        remembered: What it last said.
    """

    lamp: LightFeatures
    remembered: Remembered

    def add_readers(self, config: DiscoveryConfig, entity: Entity) -> frozenset[str]:
        """Have *entity* read all topics of the lamp's config; return the capabilities that can be read."""
        states: dict[str, bool | None] = {
            config.text("payload_off", "OFF"): False,
            config.text("payload_on", "ON"): True,
            "None": None,
        }
        readable = set()

        def add_reader(capability: str, name: str, read: Callable[[str], Readings]) -> None:
            source = config.source(f"{name}_state_topic".lstrip("_"), f"{name or 'state'}_value_template")
            if source is not None and name:
                source = source.without_payload()
            if entity.read_text_from(source, read):
                readable.add(capability)

        add_reader("on_off", "", lambda text: {"on_off": states[text]} if text in states else NO_READINGS)
        if self.lamp.has_level:
            add_reader("level", "brightness", partial(self._level, config.integer("brightness_scale", _BYTE, least=1)))
        mode_source = config.source("color_mode_state_topic", "color_mode_value_template")
        if mode_source is not None and entity.read_text_from(mode_source.without_payload(), self._mode):
            self.remembered.has_mode = True
        if self.lamp.has_white:
            add_reader("color_temperature", "color_temp", partial(self._white, config.flag("color_temp_kelvin")))
        own_level = bool(config.state_topic("brightness_state_topic"))
        for mode in CHANNELS:
            if mode in self.lamp.modes:
                add_reader("color", mode, partial(self._color, mode, own_level or mode in ("hs", "xy")))
                if not own_level and mode not in ("hs", "xy") and "color" in readable:
                    readable.add("level")
        if self.lamp.effects or self.lamp.any_effect:
            add_reader("effect", "effect", lambda text: {"effect": clean_text(text)} if text else NO_READINGS)
        return frozenset(readable)

    def _white(self, in_kelvin: bool, text: str) -> Readings:  # noqa: FBT001 - bound once, above
        kelvin = white_kelvin(whole_of(text), in_kelvin=in_kelvin)
        if kelvin is None:
            return NO_READINGS
        return self._report("color_temp", kelvin)

    def _mode(self, text: str) -> Readings:
        """Take which of its values it shows; the others were said before, or will be."""
        if text not in self.lamp.modes:
            return NO_READINGS
        self.remembered.mode = text
        reported = self.remembered.reported.get(text)
        return NO_READINGS if reported is None else self._report(text, reported)

    def _report(self, mode: str, value: PlainValue) -> Readings:
        """Take what it says in a colour mode; where it says the mode too, that decides whether it counts."""
        self.remembered.reported[mode] = value
        if self.remembered.has_mode and self.remembered.mode not in (None, mode):
            return NO_READINGS
        if mode == "color_temp":
            return {"color_temperature": value} | ({"color": None} if self.lamp.color_mode else {})
        return {"color": value} | ({"color_temperature": None} if self.lamp.has_white else {})

    def _level(self, scale: int, text: str) -> Readings:
        value = number_of(text) or 0
        if value <= 0:
            return NO_READINGS
        self.remembered.brightness = max(round(min(value / scale, 1) * _BYTE), 1)
        return {"level": self.remembered.brightness * 100 / _BYTE}

    def _color(self, mode: str, own_level: bool, text: str) -> Readings:  # noqa: FBT001 - bound once, above
        """A colour whose lamp has no topic for its brightness tells that as well."""
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
            self.remembered.brightness = brightness
            found["level"] = brightness * 100 / _BYTE
        self.remembered.colors[mode] = channels
        return {**found, **self._report(mode, to_hue_saturation(mode, channels, self.lamp.white.kelvins))}


_MOST = {"hs": (360, 100), "xy": (1, 1)}
