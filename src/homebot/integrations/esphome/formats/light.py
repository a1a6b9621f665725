"""Lights of ESPHome: the abilities of their colour modes, and the mode that a command needs. Pure.

A colour mode is a set of abilities as bits; a state says which one is active, and only its fields count.

Source: ESPHome 2026.10, ``components/light/color_mode.h`` and ``light_call.cpp``.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from homebot.conventions.command_values import require_color, require_number
from homebot.conventions.entity_rows import EntityComponent, EntityRow, Fields, options_of
from homebot.conventions.light_color import MIRED, KelvinRange, from_hue_saturation, to_hue_saturation
from homebot.devices.value import PlainValue
from homebot.integrations.esphome.formats.entity import choice_row, flag_row, number_of, numbers_of, read_percent

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
_MAX_MIRED = 1000.0
_USUAL_KELVINS = (2_000, 6_535)


def _write_level(_info: Fields, value: PlainValue, _code: str) -> Fields:
    level = require_number("level", value, 0, 100, "%")
    return {"state": True, "brightness": level / 100} if level else {"state": False}


def _first_mode(modes: Iterable[int], info: Fields) -> int:
    """Return the best of *modes* that the light has; 0 for none."""
    known = numbers_of(info, "supported_color_modes")
    return next((mode for mode in modes if mode in known), 0)


def _mired_range(info: Fields) -> tuple[float, float]:
    """Return coldest and warmest white in mired; zeros if it has no valid range."""
    coldest, warmest = (number_of(info, name) or 0.0 for name in ("min_mireds", "max_mireds"))
    return (coldest, warmest) if 1 <= coldest <= warmest <= _MAX_MIRED else (0.0, 0.0)


def _kelvin_bounds(info: Fields) -> tuple[float, ...]:
    coldest, warmest = _mired_range(info)
    return (float(round(MIRED / warmest)), float(round(MIRED / coldest))) if coldest else ()


def _kelvins(info: Fields) -> KelvinRange:
    bounds = _kelvin_bounds(info)
    return (int(bounds[0]), int(bounds[1])) if bounds else _USUAL_KELVINS


def _read_white(info: Fields, state: Fields) -> PlainValue:
    mode = state.get("color_mode")
    if not isinstance(mode, int) or mode not in _WHITES or (mode & _RGB and not _is_white(mode, state)):
        return None
    mired = number_of(state, "color_temperature")
    if mode & _COLD_WARM:
        mired = _mixed(info, state, mired)
    return None if not mired or not 1 <= mired <= _MAX_MIRED else float(round(MIRED / mired))


def _write_white(info: Fields, value: PlainValue, _code: str) -> Fields:
    mode, (coldest, warmest) = _first_mode(_WHITES, info), _mired_range(info)
    low, high = _kelvins(info)
    kelvin = require_number("color_temperature", value, low, high, "K")
    state = {"state": True, "color_mode": mode, "color_temperature": min(max(MIRED / kelvin, coldest), warmest)}
    if mode & _RGB:
        state["color_brightness"] = 0.0
        return {**state, "white": 1.0} if mode & _COLOR_TEMPERATURE else state
    return state


def _mixed(info: Fields, state: Fields, reported: float | None) -> float | None:
    """Return the mired of a mixture of two whites: the reported one, unless the channels contradict it.

    The reported value is its last command as a colour temperature; the channels are not linear (gamma).
    """
    cold, warm = number_of(state, "cold_white") or 0.0, number_of(state, "warm_white") or 0.0
    if min(cold, warm) < 0 or not cold + warm:
        return None
    coldest, warmest = _mired_range(info)
    middle = (coldest + warmest) / 2
    if reported is not None and coldest <= reported <= warmest and (reported - middle) * (warm - cold) >= 0:
        return reported
    return coldest + (warmest - coldest) * warm / (cold + warm)


def _is_white(mode: int, state: Fields) -> bool:
    """Return whether a lamp in a mode with colours and white shines white only."""
    return mode in (47, 51) and number_of(state, "color_brightness") == 0


def _read_color(info: Fields, state: Fields) -> PlainValue:
    mode = state.get("color_mode")
    if not isinstance(mode, int) or mode not in _CHANNELS or _is_white(mode, state):
        return None
    letters, whites = _CHANNELS[mode]
    shares = _shares(state, ("color_brightness", "red", "green", "blue", *whites))
    if shares is None:
        return None
    strength, *channels = shares
    rgb = [channel * (strength if whites else 1.0) for channel in channels[:3]]
    return to_hue_saturation(letters, tuple(round(255 * channel) for channel in (*rgb, *channels[3:])), _kelvins(info))


def _shares(state: Fields, names: tuple[str, ...]) -> list[float] | None:
    """Return the numbers from 0 to 1 with these *names*; None if one of them is none."""
    values = [number_of(state, name) for name in names]
    shares = [value for value in values if value is not None and 0 <= value <= 1]
    return shares if len(shares) == len(values) else None


def _write_color(info: Fields, value: PlainValue, _code: str) -> Fields:
    mode = _first_mode(_CHANNELS, info)
    letters, whites = _CHANNELS[mode]
    hue, saturation = require_color(value)
    channels = [channel / 255 for channel in from_hue_saturation(letters, hue, saturation, _kelvins(info))]
    strength = max(channels[:3])
    rgb = tuple(channel / strength for channel in channels[:3]) if strength else (1.0, 1.0, 1.0)
    state = {"state": True, "color_mode": mode, "rgb": rgb, "color_brightness": strength}
    if mode & _COLOR_TEMPERATURE:
        state["white"] = 0.0
    return {**state, **dict(zip(whites, channels[3:], strict=True))}


def _effects(info: Fields) -> Mapping[str, object]:
    listed = options_of(info, "effects")
    names = listed if _NO_EFFECT in listed or not listed else (_NO_EFFECT, *listed)
    return {name: name for name in names}


LIGHT: Final = EntityComponent(
    "light",
    (
        flag_row("on_off", "state"),
        EntityRow(
            "level",
            read_percent("brightness"),
            _write_level,
            when=lambda info: any(mode & _BRIGHTNESS for mode in numbers_of(info, "supported_color_modes")),
        ),
        EntityRow(
            "color_temperature",
            _read_white,
            _write_white,
            when=lambda info: _first_mode(_WHITES, info) and _kelvin_bounds(info),
            bounds=_kelvin_bounds,
        ),
        EntityRow("color", _read_color, _write_color, when=lambda info: _first_mode(_CHANNELS, info)),
        choice_row("effect", "effect", _effects, state=True),
    ),
)
