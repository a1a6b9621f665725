"""Thermostats, air conditioners, water heaters, humidifiers and fans as rows. Pure.

Source: Home Assistant core 2024.3, ``components``: climate, fan, humidifier and water_heater.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.esphome.entity import EntityRow, EsphomeComponent, Fields, options_of, read_flag, whole_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.homeassistant.rows import (
    SWITCH_ROW,
    bounds_of,
    celsius_row,
    choice_row,
    has,
    number_row,
    read_celsius,
    read_number,
    read_text,
    target,
    write_celsius,
)
from homebot.support.numbers import to_number

__all__ = ["CLIMATE", "FAN", "HUMIDIFIER", "WATER_HEATER"]

_SINGLE, _PAIR, _HUMIDITY, _FAN, _PRESET, _SWING = 1, 2, 4, 8, 16, 32
_LOW, _HIGH = "target_temp_low", "target_temp_high"
_HEATS, _COOLS = frozenset({"heat", "heat_cool", "auto"}), frozenset({"cool", "heat_cool"})
_SWITCHED_ON = ("heat_cool", "heat", "cool")


def _modes(info: Fields) -> tuple[str, ...]:
    return options_of(info, "hvac_modes")


def _climate_type(info: Fields) -> str:
    """Return the type: an air conditioner cools and can also dry or only ventilate."""
    modes = _modes(info)
    return "room_air_conditioner" if "cool" in modes and ("dry" in modes or "fan_only" in modes) else "thermostat"


def _is_pair(info: Fields) -> bool:
    """Return whether the pair of targets is effective now, not the single one."""
    features = whole_of(info, "supported_features")
    return bool(features & _PAIR) and (not features & _SINGLE or info.get("state") == "heat_cool")


def _has_single(info: Fields, modes: Iterable[str]) -> bool:
    return bool(whole_of(info, "supported_features") & _SINGLE) and not set(modes).isdisjoint(_modes(info))


def _has_heating(info: Fields) -> bool:
    single = whole_of(info, "supported_features") & _SINGLE and _COOLS.isdisjoint(_modes(info))
    return bool(single or _has_single(info, _HEATS) or has(_PAIR)(info))


def _has_cooling(info: Fields) -> bool:
    return _has_single(info, _COOLS) or bool(has(_PAIR)(info))


def _setpoint(name: str, end: str, when: Callable[[Fields], bool]) -> EntityRow:
    """Return the row of a setpoint: one end of the pair in the mode ``heat_cool``, and else the single target."""

    def read(info: Fields, state: Fields) -> PlainValue:
        return read_celsius(end if _is_pair(info) else "temperature")(info, state)

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        number = write_celsius(name, info, value)
        if not _is_pair(info):
            if not whole_of(info, "supported_features") & _SINGLE:
                raise RefusedError(f"{name} {number:g}", "it has no such setpoint in its mode")
            return {"service": "set_temperature", "temperature": number}
        ends = {one: to_number(info.get(one)) for one in (_LOW, _HIGH)} | {end: number}
        if None in ends.values():
            raise RefusedError(f"{name} {number:g}", "its other setpoint is unknown, and both are set together")
        return {"service": "set_temperature", **ends}

    return target(name, read, write, when)


def _write_on(info: Fields, value: PlainValue, _code: str) -> Fields:
    """Switch by means of the mode, as Home Assistant does."""
    modes, is_on = _modes(info), require_bool("on_off", value)
    wanted = (*_SWITCHED_ON, *(mode for mode in modes if mode != "off")) if is_on else ("off",)
    mode = next((mode for mode in wanted if mode in modes), None)
    if mode is None:
        raise RefusedError(f"on_off {value}", f"none of its modes is that: {', '.join(modes)[:200]}")
    return {"service": "set_hvac_mode", "hvac_mode": mode}


def _humidity_row(name: str, when: object) -> EntityRow:
    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        least, most = bounds_of(info, "min_humidity", "max_humidity") or (0.0, 100.0)
        return {"service": "set_humidity", "humidity": round(require_number(name, value, least, most, "%"))}

    return EntityRow(
        name,
        number_row(name, "humidity").read,
        write,
        "",
        when if callable(when) else None,
        bounds=lambda info: bounds_of(info, "min_humidity", "max_humidity"),
    )


_MEASURED_HUMIDITY: Final = number_row("humidity", "current_humidity", when=lambda info: "current_humidity" in info)

CLIMATE: Final = EsphomeComponent(
    _climate_type,
    (
        _setpoint("heating_setpoint", _LOW, _has_heating),
        _setpoint("cooling_setpoint", _HIGH, _has_cooling),
        celsius_row("local_temperature", "current_temperature"),
        _MEASURED_HUMIDITY,
        _humidity_row("humidity_setpoint", has(_HUMIDITY)),
        choice_row("thermostat_mode", "state", "hvac_modes", "set_hvac_mode", "hvac_mode"),
        EntityRow("on_off", lambda _info, state: state.get("state") != "off", _write_on, "", _modes),
        EntityRow("thermostat_action", read_text("hvac_action"), when=lambda info: "hvac_action" in info),
        choice_row("fan_mode", "fan_mode", "fan_modes", "set_fan_mode", when=has(_FAN)),
        choice_row("preset_mode", "preset_mode", "preset_modes", "set_preset_mode", when=has(_PRESET)),
        choice_row("swing_mode", "swing_mode", "swing_modes", "set_swing_mode", when=has(_SWING)),
    ),
)


def _write_heater(info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "set_temperature", "temperature": write_celsius("heating_setpoint", info, value)}


_WATER_TARGET, _WATER_MODE, _WATER_SWITCH = 1, 2, 8

WATER_HEATER: Final = EsphomeComponent(
    "water_heater",
    (
        target("heating_setpoint", read_celsius("temperature"), _write_heater, has(_WATER_TARGET)),
        celsius_row("local_temperature", "current_temperature"),
        choice_row(
            "water_heater_mode",
            "state",
            "operation_list",
            "set_operation_mode",
            "operation_mode",
            has(_WATER_MODE),
        ),
        EntityRow(
            "on_off",
            lambda _info, state: state.get("state") != "off",
            SWITCH_ROW.write,
            "",
            has(_WATER_SWITCH),
        ),
    ),
)

HUMIDIFIER: Final = EsphomeComponent(
    "x_humidifier",
    (
        SWITCH_ROW,
        _humidity_row("humidity_setpoint", None),
        _MEASURED_HUMIDITY,
        choice_row("humidifier_mode", "mode", "available_modes", "set_mode", when=has(1)),
    ),
)


def _write_direction(_info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "set_direction", "direction": require_option("direction", value, ("forward", "reverse"))}


def _write_oscillation(_info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "oscillate", "oscillating": require_bool("oscillation", value)}


def _read_speed(info: Fields, state: Fields) -> PlainValue:
    """Read the speed; Home Assistant has none of a fan that is off."""
    return 0.0 if state.get("state") == "off" else read_number("percentage", 1.0, 0, 100)(info, state)


_SPEED = number_row("fan_speed", "percentage", "set_percentage", when=has(1))

FAN: Final = EsphomeComponent(
    "fan",
    (
        SWITCH_ROW,
        replace(_SPEED, read=_read_speed),
        EntityRow("oscillation", read_flag("oscillating"), _write_oscillation, "", has(2)),
        EntityRow("direction", read_text("direction"), _write_direction, "", has(4)),
        choice_row("preset_mode", "preset_mode", "preset_modes", "set_preset_mode", when=has(8)),
    ),
)
