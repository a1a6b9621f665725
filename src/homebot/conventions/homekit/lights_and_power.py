"""The services of lamps, plugs, switches, fans, speakers and televisions. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 (services) and 9 (characteristics): 8.2 Air Purifier,
8.13 Fan, 8.23 Light Bulb, 8.29 Outlet, 8.36 Speaker, 8.38 Switch.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from homebot.conventions.command_values import require_color, require_number
from homebot.conventions.homekit.accessory import HapService
from homebot.conventions.homekit.rows import ServiceRow, Writes, read_number
from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.devices.value import PlainValue

__all__ = ["POWER_ROWS"]

LIGHT, SWITCH, OUTLET, SIMPLE_FAN, FAN, PURIFIER, HEATER = "43", "49", "47", "40", "B7", "BB", "BC"
SPEAKER, SMART_SPEAKER, TELEVISION = "113", "228", "D8"
ON, ACTIVE, BRIGHTNESS, HUE, SATURATION, MIREDS, SPEED = "25", "B0", "8", "13", "2F", "CE", "29"
_FANS: Final = f"{SIMPLE_FAN} {FAN} {PURIFIER}"
_DIRECTIONS: Final = {0: "forward", 1: "reverse"}
_FAN_MODES: Final = {0: "manual", 1: "auto"}
_EVE: Final = "E863F1{}-079E-48FF-8F27-9C2605A29F52"
"""The types by which Eve's plugs measure."""


def _mired_bounds(service: HapService) -> tuple[float, float]:
    least, most = service.characteristics[MIREDS].bounds or (50.0, 400.0)
    return (least, most) if 25 <= least < most <= 1000 else (50.0, 400.0)


def _kelvin_bounds(service: HapService) -> tuple[float, float]:
    return nearest_mired_bounds(*_mired_bounds(service))


def _read_kelvin(service: HapService) -> PlainValue:
    mireds = service.number(MIREDS)
    return float(round(MIRED / mireds)) if mireds is not None and 25 <= mireds <= 1000 else None


def _write_kelvin(service: HapService, value: PlainValue) -> Writes:
    return {MIREDS: MIRED / require_number("color_temperature", value, *_kelvin_bounds(service), "K"), ON: 1}


def _read_color(service: HapService) -> PlainValue:
    hue, saturation = service.number(HUE), service.number(SATURATION)
    is_known = hue is not None and saturation is not None and 0 <= hue <= 360 and 0 <= saturation <= 100
    return (hue, saturation) if is_known else None  # type: ignore[return-value]  # a number each


def _write_color(_at: HapService, value: PlainValue) -> Writes:
    hue, saturation = require_color(value)
    return {HUE: hue, SATURATION: saturation, ON: 1}


def _switch_of(service: HapService) -> str:
    return ON if ON in service.characteristics else ACTIVE


def _read_speed(service: HapService) -> PlainValue:
    if service.number(_switch_of(service)) == 0:
        return 0.0  # it keeps the speed of before
    return read_number("fan_speed", SPEED, service)


def _writer(capability: str, kind: str) -> Callable[[HapService, PlainValue], Writes]:
    """Return what sets a percentage, by which 0 turns off."""

    def write(service: HapService, value: PlainValue) -> Writes:
        percent = require_number(capability, value, 0.0, 100.0, "%")
        return {kind: max(1.0, percent), _switch_of(service): 1} if percent > 0 else {_switch_of(service): 0}

    return write


POWER_ROWS: Final = (
    ServiceRow(f"{LIGHT} {SWITCH} {OUTLET} {SIMPLE_FAN}", "on_off", ON, ON),
    ServiceRow(f"{FAN} {PURIFIER} {TELEVISION}", "on_off", ACTIVE, ACTIVE),
    ServiceRow(LIGHT, "level", BRIGHTNESS, BRIGHTNESS, write=_writer("level", BRIGHTNESS)),
    ServiceRow(LIGHT, "color_temperature", MIREDS, MIREDS, None, _read_kelvin, _write_kelvin, bounds=_kelvin_bounds),
    ServiceRow(LIGHT, "color", f"{HUE} {SATURATION}", HUE, None, _read_color, _write_color),
    ServiceRow(OUTLET, "plugged_in", "26"),
    ServiceRow(_FANS, "fan_speed", f"{SPEED} {ON} {ACTIVE}", SPEED, None, _read_speed, _writer("fan_speed", SPEED)),
    ServiceRow(FAN, "fan_mode", "BF", "BF", _FAN_MODES),
    ServiceRow(PURIFIER, "fan_mode", "A8", "A8", _FAN_MODES),
    ServiceRow(f"{_FANS} {HEATER}", "oscillation", "B6", "B6"),
    ServiceRow(_FANS, "direction", "28", "28", _DIRECTIONS),
    ServiceRow(f"{SPEAKER} {SMART_SPEAKER}", "volume", "119", "119"),
    ServiceRow(f"{OUTLET} {SWITCH}", "power", _EVE.format("0D")),
    ServiceRow(f"{OUTLET} {SWITCH}", "energy", _EVE.format("0C")),
    ServiceRow(f"{OUTLET} {SWITCH}", "voltage", _EVE.format("0A")),
    ServiceRow(f"{OUTLET} {SWITCH}", "current", _EVE.format("26")),
)
