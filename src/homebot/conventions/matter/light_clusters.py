"""The clusters of lamps: On/Off, Level Control and Color Control. Pure.

Source: Matter 1.4 Application Clusters, 1.5 (On/Off), 1.6 (Level Control), 3.2 (Color Control).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from homebot.conventions.command_values import require_color, require_number, require_transition
from homebot.conventions.light_color import MIRED, from_hue_saturation, nearest_mired_bounds, to_hue_saturation
from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["light_abilities"]

ON_OFF, LEVEL, LOCK, COLOR = 6, 8, 257, 768

_ON_OFF_VALUE = 0
_OFF_ONLY: Final = 1 << 2
_CURRENT_LEVEL, _MIN_LEVEL, _MAX_LEVEL = 0, 2, 3
_HUE, _SATURATION, _X, _Y, _MIREDS, _COLOR_MODE = 0, 1, 3, 4, 7, 8
_ENHANCED_HUE, _ENHANCED_MODE, _CAPABILITIES, _LEAST_MIREDS, _MOST_MIREDS = 0x4000, 0x4001, 0x400A, 0x400B, 0x400C
_HAS_HUE, _HAS_ENHANCED_HUE, _HAS_XY, _HAS_MIREDS = 1 << 0, 1 << 1, 1 << 3, 1 << 4
_MODE_XY, _MODE_MIREDS = 1, 2

_SPEAKER: Final = 0x0022
_WHITES: Final = (2000, 6500)
_TENTHS: Final = 10.0
_LONGEST: Final = 6553.0
"""Seconds of a transition: tenths of them in 16 bits."""

_ALSO_WHEN_OFF: Final = {"optionsMask": 1, "optionsOverride": 1}
"""ExecuteIfOff: a lamp that is off takes the new colour, and is turned on after it."""

_NO_OPTIONS: Final = {"optionsMask": 0, "optionsOverride": 0}


def light_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield on and off, level and colour, as the endpoint has them."""
    if endpoint.has(ON_OFF, _ON_OFF_VALUE) and not endpoint.has(LOCK):  # that of a lock may well move its bolt
        yield MatterAbility(ON_OFF, Capability(name="on_off", settable=True), _read_on, _write_on)
    if endpoint.has(LEVEL, _CURRENT_LEVEL):
        name = "volume" if _SPEAKER in endpoint.device_types else "level"
        yield MatterAbility(LEVEL, Capability(name=name, settable=True), _read_level, _write_level)
    if endpoint.has(COLOR):
        yield from _color_abilities(endpoint)


def _color_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    features = _color_features(endpoint)
    if features & _HAS_MIREDS:
        bounds = _kelvin_bounds(endpoint)
        capability = Capability(name="color_temperature", settable=True, bounds=bounds)
        yield MatterAbility(COLOR, capability, _read_kelvin, _write_kelvin)
    if features & (_HAS_HUE | _HAS_XY):
        yield MatterAbility(COLOR, Capability(name="color", settable=True), _read_color, _write_color)


def _color_features(endpoint: MatterEndpoint) -> int:
    return endpoint.features(COLOR) or endpoint.whole(COLOR, _CAPABILITIES) or 0


def _read_on(endpoint: MatterEndpoint) -> PlainValue:
    return endpoint.flag(ON_OFF, _ON_OFF_VALUE)


def _write_on(endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    if value is True and endpoint.features(ON_OFF) & _OFF_ONLY:
        raise RefusedError("on_off true", "the device can only be turned off, as a cooktop for safety")
    return (ClusterInvocation(ON_OFF, "On" if value is True else "Off"),)


def _levels(endpoint: MatterEndpoint) -> tuple[int, int]:
    """Return the lowest and the highest level; 0 is none, as it means off."""
    most = endpoint.whole(LEVEL, _MAX_LEVEL)
    most = most if most is not None and 1 <= most <= 254 else 254
    least = endpoint.whole(LEVEL, _MIN_LEVEL)
    return (min(max(least, 1), most) if least is not None else 1), most


def _read_level(endpoint: MatterEndpoint) -> PlainValue:
    level = endpoint.number(LEVEL, _CURRENT_LEVEL)
    if level is None or not 0 <= level <= 254:
        return None
    return min(round(level * 100 / _levels(endpoint)[1], 2), 100.0)


def _write_level(endpoint: MatterEndpoint, value: PlainValue, transition: float, _code: str) -> tuple[MatterOrder, ...]:
    percent = require_number("level", value, 0.0, 100.0, "%")
    least, most = _levels(endpoint)
    level = max(least, round(percent * most / 100)) if percent > 0 else 0
    payload = {"level": level, "transitionTime": _tenths(transition), **_NO_OPTIONS}
    has_switch = endpoint.has(ON_OFF) and _SPEAKER not in endpoint.device_types
    return (ClusterInvocation(LEVEL, "MoveToLevelWithOnOff" if has_switch else "MoveToLevel", payload),)


def _mired_range(endpoint: MatterEndpoint) -> tuple[float, float]:
    least, most = endpoint.number(COLOR, _LEAST_MIREDS), endpoint.number(COLOR, _MOST_MIREDS)
    if least is None or most is None or not 25 <= least < most <= 1000:
        return MIRED / _WHITES[1], MIRED / _WHITES[0]
    return least, most


def _kelvin_bounds(endpoint: MatterEndpoint) -> tuple[float, float]:
    return nearest_mired_bounds(*_mired_range(endpoint))


def _mode(endpoint: MatterEndpoint) -> int | None:
    mode = endpoint.whole(COLOR, _ENHANCED_MODE)
    return endpoint.whole(COLOR, _COLOR_MODE) if mode is None else mode


def _read_kelvin(endpoint: MatterEndpoint) -> PlainValue:
    mireds = endpoint.number(COLOR, _MIREDS)
    has_color = _color_features(endpoint) & (_HAS_HUE | _HAS_XY)
    if mireds is None or not 1 <= mireds <= 65_279 or (has_color and _mode(endpoint) != _MODE_MIREDS):
        return None
    return float(round(MIRED / mireds))


def _write_kelvin(
    endpoint: MatterEndpoint, value: PlainValue, transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    kelvin = require_number("color_temperature", value, *_kelvin_bounds(endpoint), "K")
    least, most = _mired_range(endpoint)
    mireds = round(min(max(MIRED / kelvin, least), most))
    payload = {"colorTemperatureMireds": mireds, "transitionTime": _tenths(transition), **_ALSO_WHEN_OFF}
    return (ClusterInvocation(COLOR, "MoveToColorTemperature", payload), *_lit(endpoint))


def _read_color(endpoint: MatterEndpoint) -> PlainValue:
    mode = _mode(endpoint)
    if mode == _MODE_MIREDS:
        return None
    if mode == _MODE_XY or not _color_features(endpoint) & _HAS_HUE:
        x, y = endpoint.number(COLOR, _X), endpoint.number(COLOR, _Y)
        if x is None or y is None or not 0 <= x <= 65_279 or not 0 <= y <= 65_279:
            return None
        return to_hue_saturation("xy", (x / 65_536, y / 65_536), _WHITES)
    hue, saturation = endpoint.number(COLOR, _HUE), endpoint.number(COLOR, _SATURATION)
    enhanced = endpoint.number(COLOR, _ENHANCED_HUE)
    if enhanced is not None and 0 <= enhanced <= 65_535:
        degrees = enhanced * 360 / 65_536
    elif hue is not None and 0 <= hue <= 254:
        degrees = hue * 360 / 254
    else:
        return None
    if saturation is None or not 0 <= saturation <= 254:
        return None
    return round(degrees, 2), round(saturation * 100 / 254, 2)


def _write_color(endpoint: MatterEndpoint, value: PlainValue, transition: float, _code: str) -> tuple[MatterOrder, ...]:
    hue, saturation = require_color(value)
    features = _color_features(endpoint)
    common = {"transitionTime": _tenths(transition), **_ALSO_WHEN_OFF}
    if not features & _HAS_HUE:
        x, y = from_hue_saturation("xy", hue, saturation, _WHITES)
        payload = {"colorX": min(round(x * 65_536), 65_279), "colorY": min(round(y * 65_536), 65_279), **common}
        return (ClusterInvocation(COLOR, "MoveToColor", payload), *_lit(endpoint))
    strength = round(saturation * 254 / 100)
    if features & _HAS_ENHANCED_HUE:
        payload = {"enhancedHue": round(hue * 65_536 / 360) % 65_536, "saturation": strength, **common}
        return (ClusterInvocation(COLOR, "EnhancedMoveToHueAndSaturation", payload), *_lit(endpoint))
    payload = {"hue": round(hue * 254 / 360), "saturation": strength, **common}
    return (ClusterInvocation(COLOR, "MoveToHueAndSaturation", payload), *_lit(endpoint))


def _lit(endpoint: MatterEndpoint) -> tuple[MatterOrder, ...]:
    """Return the order that turns a lamp on, which a colour does not; none if it has no switch."""
    return (ClusterInvocation(ON_OFF, "On"),) if endpoint.has(ON_OFF, _ON_OFF_VALUE) else ()


def _tenths(seconds: float) -> int:
    return round(require_transition(seconds, _LONGEST) * _TENTHS)
