"""Lights of ESPHome: the abilities of their colour modes, and the mode that a command needs. Pure.

A colour mode is a set of abilities as bits; a state says which one is active, and only its fields count.

Source: ESPHome 2026.10, ``components/light/color_mode.h`` and ``light_call.cpp``.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.conventions.esphome.entity import (
    EsphomeEntity,
    Fields,
    flag_reader,
    number_of,
    numbers_of,
    options_of,
    percent_reader,
    table_reader,
)
from homebot.conventions.light_color import MIRED, KelvinRange, from_hue_saturation, to_hue_saturation
from homebot.devices.value import PlainValue

__all__ = ["build_light"]

_BRIGHTNESS, _COLOR_TEMPERATURE, _COLD_WARM, _RGB = 2, 8, 16, 32
_CHANNELS: Mapping[int, tuple[str, tuple[str, ...]]] = {
    35: ("rgb", ()),
    39: ("rgbw", ("white",)),
    51: ("rgbww", ("cold_white", "warm_white")),
    47: ("rgb", ()),
}
"""Colour modes with colours, best first: in which channels of :data:`CHANNELS` they count, and the fields of white."""

_WHITES = (11, 19, 47, 51)
"""Colour modes with whites from warm to cold, best first."""

_NO_EFFECT = "None"


def build_light(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a light by the colour modes that it has."""
    entity = EsphomeEntity(kind, info, "light")
    modes = numbers_of(info, "supported_color_modes")
    whites = _Whites(info)
    entity.add("on_off", flag_reader("state"), lambda value, _code: {"state": require_bool("on_off", value)})
    if any(mode & _BRIGHTNESS for mode in modes):
        entity.add("level", percent_reader("brightness"), _write_level)
    white_mode = next((mode for mode in _WHITES if mode in modes), 0)
    if white_mode and whites.bounds:
        entity.add(
            "color_temperature",
            whites.read,
            lambda value, _code: whites.fields(white_mode, value),
            bounds=whites.bounds,
        )
    color_mode = next((mode for mode in _CHANNELS if mode in modes), 0)
    if color_mode:
        entity.add(
            "color",
            lambda state: _read_color(state, whites.kelvins),
            lambda value, _code: _color_fields(color_mode, value, whites.kelvins),
        )
    if effects := options_of(info, "effects"):
        effects = effects if _NO_EFFECT in effects else (_NO_EFFECT, *effects)
        entity.add(
            "effect",
            table_reader("effect", {one: one for one in effects}),
            lambda value, _code: {"state": True, "effect": require_option("effect", value, effects)},
            options=effects,
        )
    return entity


def _write_level(value: PlainValue, _code: str) -> Fields:
    level = require_number("level", value, 0, 100, "%")
    return {"state": True, "brightness": level / 100} if level else {"state": False}


class _Whites:
    """The range of white of a light, which ESPHome gives in mired.

    Attributes:
        bounds: Warmest and coldest in kelvin; empty if it says none.
        kelvins: The same, or the usual ones.
    """

    def __init__(self, info: Fields) -> None:
        self._coldest = number_of(info, "min_mireds") or 0.0
        self._warmest = number_of(info, "max_mireds") or 0.0
        self.bounds: tuple[float, ...] = ()
        if 1 <= self._coldest <= self._warmest <= _MOST_MIRED:
            self.bounds = float(round(MIRED / self._warmest)), float(round(MIRED / self._coldest))
        self.kelvins: KelvinRange = (int(self.bounds[0]), int(self.bounds[1])) if self.bounds else _USUAL_KELVINS

    def read(self, state: Fields) -> PlainValue:
        mode = state.get("color_mode")
        if not isinstance(mode, int) or mode not in _WHITES or (mode & _RGB and not _is_white(mode, state)):
            return None
        mired = number_of(state, "color_temperature")
        if mode & _COLD_WARM:
            mired = self._mixed(state, mired)
        return None if not mired or not 1 <= mired <= _MOST_MIRED else float(round(MIRED / mired))

    def fields(self, mode: int, value: PlainValue) -> Fields:
        kelvin = require_number("color_temperature", value, self.bounds[0], self.bounds[1], "K")
        mired = min(max(MIRED / kelvin, self._coldest), self._warmest)
        found: dict[str, object] = {"state": True, "color_mode": mode, "color_temperature": mired}
        if mode & _RGB:
            found["color_brightness"] = 0.0
        return {**found, "white": 1.0} if mode & _RGB and mode & _COLOR_TEMPERATURE else found

    def _mixed(self, state: Fields, said: float | None) -> float | None:
        """Return the mired of a mixture of two whites: the reported *said*, unless the channels contradict it.

        The reported value is its last command as a colour temperature; the channels are not linear (gamma).
        """
        cold, warm = number_of(state, "cold_white") or 0.0, number_of(state, "warm_white") or 0.0
        if min(cold, warm) < 0 or not cold + warm:
            return None
        middle = (self._coldest + self._warmest) / 2
        if said is not None and self._coldest <= said <= self._warmest and (said - middle) * (warm - cold) >= 0:
            return said
        return self._coldest + (self._warmest - self._coldest) * warm / (cold + warm)


_MOST_MIRED = 1000.0
_USUAL_KELVINS = (2_000, 6_535)


def _is_white(mode: int, state: Fields) -> bool:
    """Return whether a lamp in a mode with colours and white shines white only."""
    return mode in (47, 51) and number_of(state, "color_brightness") == 0


def _read_color(state: Fields, white: KelvinRange) -> PlainValue:
    mode = state.get("color_mode")
    if not isinstance(mode, int) or mode not in _CHANNELS or _is_white(mode, state):
        return None
    letters, whites = _CHANNELS[mode]
    strength = number_of(state, "color_brightness")
    numbers = [number_of(state, name) for name in ("red", "green", "blue", *whites)]
    if strength is None or any(one is None or not 0 <= one <= 1 for one in numbers) or not 0 <= strength <= 1:
        return None
    known = [one or 0.0 for one in numbers]
    rgb = [one * (strength if whites else 1.0) for one in known[:3]]
    return to_hue_saturation(letters, tuple(round(255 * one) for one in (*rgb, *known[3:])), white)


def _color_fields(mode: int, value: PlainValue, white: KelvinRange) -> Fields:
    letters, whites = _CHANNELS[mode]
    hue, saturation = require_color(value)
    channels = [one / 255 for one in from_hue_saturation(letters, hue, saturation, white)]
    strength = max(channels[:3])
    rgb = tuple(one / strength for one in channels[:3]) if strength else (1.0, 1.0, 1.0)
    found = {"state": True, "color_mode": mode, "rgb": rgb, "color_brightness": strength}
    if mode & _COLOR_TEMPERATURE:
        found["white"] = 0.0
    return {**found, **dict(zip(whites, channels[3:], strict=True))}
