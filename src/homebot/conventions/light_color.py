"""Colours of lamps, and of the vocabulary: hue in degrees and saturation in percent. Pure.

Numbers are rounded as in Home Assistant, so that the same command gives the same bytes.

Source: Home Assistant core 2025.4, ``util/color.py``; xy: Philips Hue, RGB to xy color conversion (wide gamut, D65);
white of a colour temperature: T. Helland, How to convert temperature (K) to RGB.
"""

import colorsys
import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

Channels: TypeAlias = tuple[float, ...]
"""The numbers of one colour, in the order of :data:`CHANNELS`."""

KelvinRange: TypeAlias = tuple[int, int]
"""Warmest and coldest white."""

CHANNELS: Mapping[str, str] = {"hs": "hs", "xy": "xy", "rgb": "rgb", "rgbw": "rgbw", "rgbww": "rgbcw"}
"""The colour modes, and the letters of their channels."""


def kelvin_mired(value: float) -> int:
    """Return mired for kelvin and kelvin for mired; *value* is above 0."""
    return math.floor(MIRED / value)


def mired_bounds(least: float, most: float) -> tuple[float, float]:
    """Return the lowest and the highest kelvin of a lamp with *least* to *most* mired, both at least 1.

    The results of :func:`kelvin_mired` for both are within these mired, rounded down, and no white is below 1,000 K: a
    Namron 1402768 claims 65,279 mired.
    """
    coldest, warmest = math.floor(min(least, 1_000)), math.floor(min(most, 1_000))
    low, high = MIRED // (warmest + 1) + 1, kelvin_mired(coldest)
    return (float(low), float(high)) if low <= high else (float(kelvin_mired(warmest)), float(high))


def nearest_mired_bounds(least: float, most: float) -> tuple[float, float]:
    """Return the lowest and the highest kelvin within *least* to *most* mired, at least 1, rounded to whole mired."""
    return float(math.floor(MIRED / (most + 0.5)) + 1), float(math.ceil(MIRED / (least - 0.5)) - 1)


def white_kelvin(value: float | None, *, in_kelvin: bool) -> float | None:
    """Return the kelvin of a reported white in kelvin or in mired; None if it is out of range."""
    if value is None or not 1 <= value <= _MAX_KELVIN:
        return None
    return float(value) if in_kelvin else float(kelvin_mired(value))


def from_hue_saturation(mode: str, hue: float, saturation: float, white: KelvinRange) -> Channels:
    """Return a colour in the channels of *mode*: 0 to 255 each, but ``hs`` as it is, and ``xy`` with three digits."""
    if mode == "hs":
        return hue, saturation
    return _FROM_RGB[mode](_rgb(hue, saturation), white)


def to_hue_saturation(mode: str, channels: Channels, white: KelvinRange) -> tuple[float, float]:
    """Return hue and saturation of a colour in the channels of *mode*, which are in their bounds."""
    if mode == "hs":
        return channels[0], channels[1]
    hue, saturation, _ = colorsys.rgb_to_hsv(*(channel / 255 for channel in _TO_RGB[mode](channels, white)))
    return round(hue * 360, 3), round(saturation * 100, 3)


MIRED = 1_000_000
_MAX_KELVIN = 1_000_000
_MIN_Y = 1e-11
"""Smallest divisor; no lamp has a smaller one, and its quotient could be infinite."""


def _rgb(hue: float, saturation: float) -> Channels:
    return tuple(round(channel * 255) for channel in colorsys.hsv_to_rgb(hue / 360, saturation / 100, 1))


def _rgb_to_xy(rgb: Channels, _white: KelvinRange) -> Channels:
    red, green, blue = (
        ((channel / 255 + 0.055) / 1.055) ** 2.4 if channel / 255 > 0.04045 else channel / 255 / 12.92
        for channel in rgb
    )
    x = red * 0.664511 + green * 0.154324 + blue * 0.162028
    y = red * 0.283881 + green * 0.668433 + blue * 0.047685
    z = red * 0.000088 + green * 0.072310 + blue * 0.986039
    total = x + y + z
    return (round(x / total, 3), round(y / total, 3)) if total else (0.0, 0.0)


def _xy_to_rgb(xy: Channels, _white: KelvinRange) -> Channels:
    x, y = xy[0], max(xy[1], _MIN_Y)
    big_x, big_z = x / y, (1 - x - y) / y
    linear = (
        big_x * 1.656492 - 0.354851 - big_z * 0.255038,
        -big_x * 0.707196 + 1.655397 + big_z * 0.036152,
        big_x * 0.051713 - 0.121364 + big_z * 1.011530,
    )
    rgb = [
        max(0.0, 12.92 * channel if channel <= 0.0031308 else 1.055 * channel ** (1 / 2.4) - 0.055)
        for channel in linear
    ]
    largest = max(*rgb, 1.0)
    return tuple(int(channel / largest * 255) for channel in rgb)


def _rgb_to_rgbw(rgb: Channels, _white: KelvinRange) -> Channels:
    white = min(rgb)
    return _as_bright(rgb, (*(channel - white for channel in rgb), white))


def _rgbw_to_rgb(rgbw: Channels, _white: KelvinRange) -> Channels:
    return _as_bright(rgbw, tuple(channel + rgbw[3] for channel in rgbw[:3]))


def _rgb_to_rgbww(rgb: Channels, white: KelvinRange) -> Channels:
    warmest, coldest = (kelvin_mired(kelvin) for kelvin in white)
    middle = white_rgb(kelvin_mired(coldest + (warmest - coldest) / 2))
    level = min(channel / part if part else 0 for channel, part in zip(rgb, middle, strict=True))
    both = round(level * 255)
    return _as_bright(rgb, (*(channel - part * level for channel, part in zip(rgb, middle, strict=True)), both, both))


def _rgbww_to_rgb(rgbww: Channels, white: KelvinRange) -> Channels:
    warmest, coldest = (kelvin_mired(kelvin) for kelvin in white)
    cold, warm = rgbww[3:]
    warm_fraction = warm / (cold + warm) if cold + warm else 0.5
    mired = coldest + warm_fraction * (warmest - coldest)
    level = max(cold, warm) / 255
    tint = white_rgb(kelvin_mired(mired) if mired else 0)
    return _as_bright(rgbww, tuple(channel + part * level for channel, part in zip(rgbww[:3], tint, strict=True)))


def _as_bright(target: Channels, channels: Channels) -> Channels:
    """Scale *channels* so that the largest is as large as the largest wanted."""
    largest = max(channels)
    factor = max(target) / largest if largest else 0.0
    return tuple(round(channel * factor) for channel in channels)


def white_rgb(kelvin: float) -> Channels:
    """Return a white of *kelvin* as red, green and blue."""
    warmth = min(max(kelvin, 1_000), 40_000) / 100
    red = 255.0 if warmth <= 66 else 329.698727446 * (warmth - 60) ** -0.1332047592
    if warmth <= 66:
        green = 99.4708025861 * math.log(warmth) - 161.1195681661
    else:
        green = 288.1221695283 * (warmth - 60) ** -0.0755148492
    blue = 255.0
    if warmth < 66:
        blue = 0.0 if warmth <= 19 else 138.5177312231 * math.log(warmth - 10) - 305.0447927307
    return tuple(min(max(channel, 0.0), 255.0) for channel in (red, green, blue))


_FROM_RGB: Mapping[str, Callable[[Channels, KelvinRange], Channels]] = {
    "rgb": lambda rgb, _white: rgb,
    "rgbw": _rgb_to_rgbw,
    "rgbww": _rgb_to_rgbww,
    "xy": _rgb_to_xy,
}
_TO_RGB: Mapping[str, Callable[[Channels, KelvinRange], Channels]] = {
    "rgb": lambda rgb, _white: rgb,
    "rgbw": _rgbw_to_rgb,
    "rgbww": _rgbww_to_rgb,
    "xy": _xy_to_rgb,
}
