"""Lamps with Tasmota firmware, and the fade speed for a transition. Pure.

Tasmota's speed is the time from dark to full, in half seconds. A smaller change needs a part of it, so the speed
depends on the current state of the lamp.

Source: tasmota.github.io/docs, Lights, and Commands > Speed2 and SetOption117; hatasmota 0.10.2, ``light.py``; rounding
as Home Assistant core 2025.4, ``components/tasmota/light.py``.
"""

import colorsys
import math
import re
from dataclasses import dataclass, field

from homebot.conventions.description import Publications
from homebot.conventions.lamp import LIGHT_CAPABILITIES, LightCommand, LightFeatures, WhiteRange
from homebot.conventions.light_color import kelvin_mired, mired_bounds
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings
from homebot.devices.value import PlainValue
from homebot.integrations.tasmota.formats.config import LIGHT, TasmotaConfig, power_commands
from homebot.support.numbers import finite_number


class LampState:
    """The last reported state of a lamp."""

    __slots__ = ("_is_on", "_level", "_mired", "_rgb")

    def __init__(self) -> None:
        self._is_on = False
        self._level = _FULL
        self._rgb: tuple[float, ...] = ()
        self._mired = 0.0

    def update(self, is_on: object, level: object, color: object, mired: object) -> None:
        """Record the values of one message; missing and invalid ones stay."""
        if isinstance(is_on, bool):
            self._is_on = is_on
        number = finite_number(level)
        if number is not None and 0 <= number <= _FULL:
            self._level = number
        self._rgb = _rgb(color) or self._rgb
        white = finite_number(mired)
        if white is not None and white > 0:
            self._mired = white

    def distance(self, command: LightCommand, kind: int, mireds: tuple[int, int]) -> float:
        """Return the largest change of a channel, as a fraction of the way from dark to full.

        Args:
            mireds: Coldest and warmest white.
        """
        level = self._level if self._is_on else 0.0
        target_level = self._level if command.on else 0.0
        if command.level is not None:
            target_level = float(_steps(command))
        changes: list[tuple[float, float]] = []
        if kind >= _COLOR and self._rgb:
            rgb = self._rgb
            if command.color:
                hue, saturation = command.color
                rgb = tuple(int(share * 255) / 255 for share in colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1))
            changes += zip(self._rgb, rgb, strict=True)
        if kind >= _WHITES and self._mired:  # the share of warm white
            coldest, warmest = mireds
            mired = self._mired if command.kelvin is None else kelvin_mired(command.kelvin)
            changes.append(((self._mired - coldest) / (warmest - coldest), (mired - coldest) / (warmest - coldest)))
        changes = changes or [(1.0, 1.0)]
        return max(abs(before * level - after * target_level) / _FULL for before, after in changes)


def speed_for(seconds: float, distance: float) -> int:
    """Return the nearest speed, 1 to 40, for a *distance* of the whole way in *seconds*."""
    half_seconds = seconds * 2 / distance if distance else 0.0
    return round(min(max(half_seconds, _MIN_HALF_SECONDS), _MAX_HALF_SECONDS))


_FULL = 100.0
_MIN_HALF_SECONDS, _MAX_HALF_SECONDS = 1, 40
_CHANNELS = 3
_DECIMAL_COLOR = re.compile("[0-9]+(?:,[0-9]+){2,}")
_HEXADECIMAL_COLOR = re.compile("(?:[0-9a-fA-F]{2}){3,}")
_MAX_TEXT = 40


def _rgb(color: object) -> tuple[float, ...]:
    """Return the shares of red, green and blue in ``FF8000...`` or ``255,128,0,...``; empty for anything else."""
    if not isinstance(color, str) or len(color) > _MAX_TEXT:
        return ()
    channels: list[int] = []
    if _DECIMAL_COLOR.fullmatch(color):
        channels = [int(part) for part in color.split(",")]
    elif _HEXADECIMAL_COLOR.fullmatch(color):
        channels = [int(color[start : start + 2], 16) for start in range(0, len(color), 2)]
    return tuple(min(channel, 255) / 255 for channel in channels[:_CHANNELS])


def add_light(part: JsonPart, config: TasmotaConfig, index: int) -> None:
    """Add the capabilities of the lamp at the output *index*."""
    if config.option(_DIMMERS_OPTION):
        channel = f"Channel{index + 1}"
        lamp = _TasmotaLamp(config, index, _DIMMER, channel, channel)
    else:
        place = index - config.outputs.index(LIGHT)  # among the lamps
        kind = config.light_type if _ON_OFF <= config.light_type <= _COLOR_WHITES else _ON_OFF
        lamp = _TasmotaLamp(config, index, kind, "Dimmer3" if config.is_tuya else "Dimmer", "Dimmer")
        if config.light_type >= _COLOR_WHITE and not config.is_linked and place < _PAIR:  # colours, and then white
            white = _DIMMER if config.light_type == _COLOR_WHITE else _WHITES
            dimmer = f"Dimmer{place + 1}"
            lamp = _TasmotaLamp(config, index, white if place else _COLOR, dimmer, dimmer)
    for topic in config.states(*power_commands(index), *_REPORTED_COMMANDS):
        part.read_from(topic, lamp.read)
    part.add_command_topics(config.topic("Backlog"))
    lamp.features.add_to(part, LIGHT_CAPABILITIES, lamp.publish)
    part.add_state_request(*config.state_requests)


_REPORTED_COMMANDS = ("Channel", "Color", "CT", "Dimmer", "HsbColor", "Scheme", "White")
"""Commands that the firmware answers with the state of the lamp."""

_ON_OFF, _DIMMER, _WHITES, _COLOR, _COLOR_WHITE, _COLOR_WHITES = range(6)
_EFFECTS = ("Solid", "Wake up", "Cycle up", "Cycle down", "Random")
_MIRED = (153, 500)
_REDUCED_MIRED = (200, 380)
_REDUCED_MIRED_OPTION, _DIMMERS_OPTION, _POWER_APART_OPTION = 82, 68, 20
_FIXED_FADE_OPTION = 117
_PAIR = 2


@dataclass(frozen=True, slots=True)
class _TasmotaLamp:
    """Reader and writers of one lamp.

    Attributes:
        last_state: Its last reported state, on which the fade speed depends.
    """

    config: TasmotaConfig
    index: int
    kind: int
    dimmer: str
    dimmer_key: str
    last_state: LampState = field(default_factory=LampState)

    @property
    def has_white(self) -> bool:
        return self.kind in (_WHITES, _COLOR_WHITES)

    @property
    def has_color(self) -> bool:
        return self.kind >= _COLOR

    @property
    def features(self) -> LightFeatures:
        coldest, warmest = self._mireds
        bounds = mired_bounds(coldest, warmest)
        modes = {"onoff"} if self.kind == _ON_OFF else {"brightness"}
        modes |= {"color_temp"} if self.has_white else set()
        return LightFeatures(
            frozenset(modes | ({"hs"} if self.has_color else set())),
            WhiteRange((int(bounds[0]), int(bounds[1])), bounds),
            effects=_EFFECTS if self.has_color else (),
            most_seconds=0.0 if self.kind == _ON_OFF or self.config.is_tuya else math.inf,
        )

    @property
    def _mireds(self) -> tuple[int, int]:
        return _REDUCED_MIRED if self.config.option(_REDUCED_MIRED_OPTION) else _MIRED

    def read(self, message: JsonMessage) -> Readings:
        is_on = self.config.read_power(self.index, message)
        readings: dict[str, PlainValue] = {} if is_on is None else {"on_off": is_on}
        self.last_state.update(is_on, message.get(self.dimmer_key), message.get("Color"), message.get("CT"))
        if self.kind == _ON_OFF:
            return readings
        level = finite_number(message.get(self.dimmer_key))
        if level is not None and 0 < level <= 100:
            readings["level"] = level
        readings.update(self._read_color(message))
        scheme = message.get("Scheme")
        if self.has_color and isinstance(scheme, int) and 0 <= scheme < len(_EFFECTS):
            readings["effect"] = _EFFECTS[scheme]
        return readings

    def publish(self, command: LightCommand) -> Publications:
        """Encode a command, the fade first: ``Fade2`` and ``Speed2`` are for the next change only."""
        power = (f"Power{self.index + 1}", self.config.state_text(command.on))
        orders: list[tuple[str, str | int]] = [power]
        if command.level is not None:
            apart = self.config.option(_POWER_APART_OPTION)
            orders = [(self.dimmer, _steps(command)), *([power] if apart else [])]
        if command.kelvin is not None:
            orders.append(("CT", kelvin_mired(command.kelvin)))
        if command.color:
            orders += [(f"HsbColor{place}", round(share)) for place, share in enumerate(command.color, 1)]
        if command.effect:
            orders.append(("Scheme", _EFFECTS.index(command.effect)))
        if command.transition:
            is_whole = self.config.option(_FIXED_FADE_OPTION)
            distance = 1.0 if is_whole else self.last_state.distance(command, self.kind, self._mireds)
            orders = [("Fade2", 1), ("Speed2", speed_for(command.transition, distance)), *orders]
        return self.config.publish_all(orders)

    def _read_color(self, message: JsonMessage) -> Readings:
        """Read the colour; a lamp with colours and white shows a colour while its white is at 0."""
        shows_white = self.kind in (_COLOR_WHITE, _COLOR_WHITES) and message.get("White") not in (None, 0)
        if self.has_color and not shows_white:
            color = _hue_saturation(message.get("HSBColor"))
            if color is None:
                return NO_READINGS
            return {"color": color, **({"color_temperature": None} if self.has_white else {})}
        readings: dict[str, PlainValue] = {"color": None} if self.has_color else {}
        mired = finite_number(message.get("CT"))
        if self.has_white and mired is not None and mired > 0:
            readings["color_temperature"] = float(kelvin_mired(mired))
        return readings


def _steps(command: LightCommand) -> int:
    """Return a brightness in percent that is rounded twice, by way of 0 to 255, as Home Assistant does."""
    return max(1, round((command.brightness or 0) / 255 * 100))


def _hue_saturation(value: object) -> tuple[float, float] | None:
    if not isinstance(value, str) or len(value) > _MAX_COLOR:
        return None
    try:
        hue, saturation, _ = (float(number) for number in value.split(","))
    except ValueError:
        return None
    return (hue, saturation) if 0 <= hue <= 360 and 0 <= saturation <= 100 else None


_MAX_COLOR = 40
