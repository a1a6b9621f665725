"""Segments of a WLED controller: their abilities, their values and their commands. Pure.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api): segment object, light capabilities; 0.13 to 16. The
white of ``cct`` has 256 steps of 32 K from 1900 K on.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from homebot.conventions.lamp import LightCommand, LightFeatures, WhiteRange
from homebot.conventions.light_color import to_hue_saturation
from homebot.conventions.payload import Readings, text_of
from homebot.devices.value import PlainValue
from homebot.support.numbers import to_number, whole_number

Fields = Mapping[str, object]

MASTER = ""
"""The part that is the whole controller."""

MAX_NAME_CHARACTERS = 60

_RGB, _WHITE, _CCT = 1, 2, 4
_MAX_SEGMENTS = 64
_FULL = 255
_WARMEST, _STEP = 1900, 32
_COLDEST = _WARMEST + _FULL * _STEP
_WHITES = WhiteRange((_WARMEST, _COLDEST), (float(_WARMEST), float(_COLDEST)))

MASTER_FEATURES = LightFeatures(frozenset({"brightness"}), _WHITES, most_seconds=math.inf)
"""The features of a controller with several segments."""


@dataclass(frozen=True, slots=True)
class WledSegment:
    """A segment with LEDs.

    Attributes:
        abilities: Bits: 1 colours, 2 a channel of white, 4 whites of different temperature.
        effects: The names of its effects, by number; those that cannot be chosen are empty.
    """

    id: int
    part: str
    name: str
    abilities: int
    fields: Fields
    effects: tuple[str, ...]

    @property
    def features(self) -> LightFeatures:
        """Its capabilities."""
        modes = {"brightness"} | ({"color_temp"} if self.abilities & _CCT else set())
        return LightFeatures(
            frozenset(modes | ({"rgb"} if self.abilities & _RGB else set())),
            _WHITES,
            effects=tuple(dict.fromkeys(effect for effect in self.effects if effect)),
            only_in_bounds=True,
            most_seconds=math.inf,
        )

    def read(self, state: Fields) -> Readings:
        """Return its readings in the *state* of the controller."""
        master, own_on = read_master(state), _flag(self.fields.get("on", True))
        master_on, own_level = master["on_off"], _byte(self.fields.get("bri", _FULL))
        master_level = _byte(state.get("bri")) if self.part == MASTER else _FULL
        level = None if own_level is None or master_level is None else own_level * master_level / _FULL
        readings = {
            "on_off": None if master_on is None or own_on is None else master_on and own_on,
            "level": _percent(level),
            **self._read_colors(),
        }
        if self.effects:
            number = self.fields.get("fx")
            is_known = isinstance(number, int) and 0 <= number < len(self.effects)
            readings["effect"] = (self.effects[number] or None) if is_known and isinstance(number, int) else None
        return readings

    def write(self, command: LightCommand) -> dict[str, object]:
        """Return the state of the controller that carries out *command*."""
        if not command.on:
            return {"on": False} if self.part == MASTER else {"seg": [{"id": self.id, "on": False}]}
        fields: dict[str, object] = {"id": self.id, "on": True}
        whole: dict[str, object] = {"on": True, "seg": [fields]}
        if command.color:
            rgb = [int(channel) for channel in command.color]
            fields["col"] = [[*rgb, 0] if len(self._channels or ()) == 4 else rgb]
        elif command.white is not None:
            fields["cct"] = round((command.white - _WARMEST) / _STEP)
            if self.abilities & _RGB:
                fields["col"] = [[0, 0, 0, _FULL] if self.abilities & _WHITE else [_FULL] * 3]
        if command.level is not None:
            fields["bri"] = command.brightness
            if self.part == MASTER:
                fields["bri"], whole["bri"] = _FULL, command.brightness
        if command.effect:
            fields["fx"] = self.effects.index(command.effect)
        return whole

    def _read_colors(self) -> dict[str, PlainValue]:
        channels, steps = self._channels, _byte(self.fields.get("cct"))
        readings: dict[str, PlainValue] = {}
        if self.abilities & _RGB:
            readings["color"] = None
            if channels is not None:
                white = channels[3] if len(channels) == 4 else 0.0
                rgb = tuple(min(_FULL, channel + white) for channel in channels[:3])
                readings["color"] = to_hue_saturation("rgb", rgb, _WHITES.kelvins)
        if self.abilities & _CCT:
            is_white = channels is not None and len(set(channels[:3])) == 1
            shows_white = is_white or not self.abilities & _RGB
            readings["color_temperature"] = _WARMEST + _STEP * steps if steps is not None and shows_white else None
        return readings

    @property
    def _channels(self) -> tuple[float, ...] | None:
        """The first of its three colours: red, green, blue and perhaps white; None if it is invalid."""
        colors = self.fields.get("col")
        first = colors[0] if isinstance(colors, list) and colors else None
        if not isinstance(first, list) or len(first) not in {3, 4}:
            return None
        channels = tuple(channel for channel in map(_byte, first) if channel is not None)
        return channels if len(channels) == len(first) else None


def read_master(state: Fields) -> dict[str, PlainValue]:
    """Return switch and level of the whole controller."""
    return {"on_off": _flag(state.get("on")), "level": _percent(_byte(state.get("bri")))}


def find_segments(state: Fields, leds: Fields, effects: tuple[str, ...]) -> Iterator[WledSegment]:
    """Yield the segments with LEDs; a single one is the master part."""
    listed = state.get("seg")
    given = [segment for segment in listed if isinstance(segment, dict)] if isinstance(listed, list) else []
    lit = [segment for segment in given[:_MAX_SEGMENTS] if segment.get("stop") != 0]
    known = leds.get("seglc")
    by_place = isinstance(known, list) and len(known) == len(lit)
    seen: set[int] = set()
    for place, fields in enumerate(lit):
        number = whole_number(fields.get("id", place))
        if number is None or not 0 <= number < _FULL or number in seen:
            continue
        seen.add(number)
        part = MASTER if len(lit) == 1 else f"segment:{number}"
        abilities = _abilities(fields, leds, place if by_place else number)
        yield WledSegment(number, part, text_of(fields.get("n"), MAX_NAME_CHARACTERS), abilities, fields, effects)


def _abilities(segment: Fields, leds: Fields, place: int) -> int:
    """Return the abilities of a segment: from 16 on it names them itself, before 0.13 no segment does."""
    known = leds.get("seglc")
    of_place = known[place] if isinstance(known, list) and place < len(known) else None
    for abilities in (segment.get("lc"), of_place, leds.get("lc")):
        if isinstance(abilities, int) and not isinstance(abilities, bool) and 0 <= abilities <= _FULL:
            return abilities
    return _RGB | (_WHITE if leds.get("rgbw") is True else 0)


def _flag(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _byte(value: object) -> float | None:
    number = to_number(value) if not isinstance(value, str) else None
    return number if number is not None and 0 <= number <= _FULL else None


def _percent(level: float | None) -> float | None:
    return None if level is None else round(level * 100 / _FULL, 1)
