"""Thermostats, air conditioners, water heaters, humidifiers and fans as rows. Pure.

Source: Home Assistant core 2024.3, ``components``: climate, fan, humidifier and water_heater.
"""

from dataclasses import replace
from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.entity_rows import (
    EntityComponent,
    EntityRow,
    Fields,
    ReadField,
    climate_type,
    grid_of,
    options_of,
    setpoints_of,
    switched_mode,
    whole_of,
)
from homebot.conventions.units import celsius_bounds, number_grid, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.formats.states.rows import (
    SWITCH,
    Condition,
    bounds_of,
    choice,
    flag,
    has,
    percent,
    read_number,
    read_text,
    read_while_on,
    sensed,
    write_switch,
)
from homebot.support.numbers import to_number

_SINGLE, _PAIR, _HUMIDITY, _FAN, _PRESET, _SWING, _SWING_HORIZONTAL = 1, 2, 4, 8, 16, 32, 512
_TURN_OFF, _TURN_ON = 128, 256
_LOW, _HIGH = "target_temp_low", "target_temp_high"
_ANY_CELSIUS = (-100.0, 200.0)


def _celsius(field: str) -> ReadField:
    def read(info: Fields, state: Fields) -> PlainValue:
        number = to_number(state.get(field))
        return to_celsius(number, 3) if number is not None and info.get("is_fahrenheit") else number

    return read


def _bounds(info: Fields) -> tuple[float, float] | tuple[()]:
    bounds = bounds_of(info, "min_temp", "max_temp")
    return celsius_bounds(*bounds) if bounds and info.get("is_fahrenheit") else bounds


def _grid(info: Fields) -> tuple[float, ...]:
    """Return the grid of setpoints, from 0 as on the pages of Home Assistant, where a step is 1 °F by default."""
    step = info.get("target_temp_step") or (1 if info.get("is_fahrenheit") else 0)
    return number_grid(0, step, is_fahrenheit=info.get("is_fahrenheit") is True)


def _modes(info: Fields) -> tuple[str, ...]:
    return options_of(info, "hvac_modes")


def _is_pair(info: Fields) -> bool:
    """Return whether the pair of targets is effective now, not the single one; Venstar has it in ``auto``."""
    features = whole_of(info, "supported_features")
    has_only_pair = info.get("temperature") is None and to_number(info.get(_LOW)) is not None
    has_pair = bool(features & _PAIR and _modes(info))  # this bit of a water heater has another meaning
    return has_pair and (not features & _SINGLE or has_only_pair or info.get("state") == "heat_cool")


def _heats(info: Fields) -> bool:
    return bool(has(_SINGLE, _PAIR)(info) and "heating_setpoint" in setpoints_of(_modes(info)))


def _cools(info: Fields) -> bool:
    """Return whether it has a target to cool to; a pair without the mode ``heat`` has both ends."""
    modes = _modes(info)
    is_pair_for_both = has(_PAIR)(info) and "heat" not in modes
    return bool(has(_SINGLE, _PAIR)(info) and (is_pair_for_both or "cooling_setpoint" in setpoints_of(modes)))


def _setpoint(name: str, end: str, when: Condition) -> EntityRow:
    """Return the row of a setpoint: one end of the pair in the mode ``heat_cool``, and else the single target."""

    def read(info: Fields, state: Fields) -> PlainValue:
        return _celsius(end if _is_pair(info) else "temperature")(info, state)

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        celsius = require_number(name, value, *(_bounds(info) or _ANY_CELSIUS), "°C")
        number = to_fahrenheit(celsius, 3) if info.get("is_fahrenheit") else celsius
        least, most = bounds_of(info, "min_temp", "max_temp") or (number, number)
        number = min(max(number, least), most)
        if not _is_pair(info):
            return {"service": "set_temperature", "temperature": number}
        ends = {field: to_number(info.get(field)) for field in (_LOW, _HIGH)} | {end: number}
        if None in ends.values():
            raise RefusedError(f"{name} {number:g}", "its other setpoint is unknown, and both are set together")
        return {"service": "set_temperature", **ends}

    return EntityRow(name, read, write, when, (), _bounds, "°C", _grid)


def _write_on(info: Fields, value: PlainValue, code: str) -> Fields:
    """Switch by the services for it, which know the last mode, or else by means of the mode."""
    if has(_TURN_ON if value else _TURN_OFF)(info):
        return write_switch(info, value, code)
    return {"service": "set_hvac_mode", "hvac_mode": switched_mode(_modes(info), value)}


def _humidity(info: Fields) -> tuple[float, float]:
    return bounds_of(info, "min_humidity", "max_humidity") or (0.0, 100.0)


def _write_humidity(info: Fields, value: PlainValue, _code: str) -> Fields:
    humidity = round(require_number("humidity_setpoint", value, *_humidity(info), "%"))
    return {"service": "set_humidity", "humidity": humidity}


_HUMIDITY_SETPOINT: Final = EntityRow(
    "humidity_setpoint",
    read_number("humidity", 1.0, 0, 100),
    _write_humidity,
    bounds=_humidity,
    grid=grid_of("target_humidity_step", "min_humidity"),
)
_MEASURED: Final = (
    sensed("local_temperature", "current_temperature", _celsius("current_temperature"), unit="°C"),
    sensed("humidity", "current_humidity", read_number("current_humidity", 1.0, 0, 100)),
)


def _is_on(_info: Fields, state: Fields) -> PlainValue:
    return None if state.get("state") is None else state.get("state") != "off"


CLIMATE: Final = EntityComponent(
    lambda info: climate_type(_modes(info)),
    (
        _setpoint("heating_setpoint", _LOW, _heats),
        _setpoint("cooling_setpoint", _HIGH, _cools),
        *_MEASURED,
        replace(_HUMIDITY_SETPOINT, when=has(_HUMIDITY)),
        choice("thermostat_mode", "state", "hvac_modes", "set_hvac_mode", "hvac_mode"),
        EntityRow("on_off", _is_on, _write_on, lambda info: "off" in _modes(info)),
        sensed("thermostat_action", "hvac_action", read_text("hvac_action")),
        choice("fan_mode", "fan_mode", "fan_modes", "set_fan_mode", when=has(_FAN)),
        choice("preset_mode", "preset_mode", "preset_modes", "set_preset_mode", when=has(_PRESET)),
        choice("swing_mode", "swing_mode", "swing_modes", "set_swing_mode", when=has(_SWING)),
        choice(
            "swing_horizontal_mode",
            "swing_horizontal_mode",
            "swing_horizontal_modes",
            "set_swing_horizontal_mode",
            when=has(_SWING_HORIZONTAL),
        ),
    ),
)

WATER_HEATER: Final = EntityComponent(  # its single target is its setpoint, as that of a thermostat
    "water_heater",
    (
        _setpoint("heating_setpoint", _LOW, has(1)),
        _MEASURED[0],
        choice("water_heater_mode", "state", "operation_list", "set_operation_mode", "operation_mode", has(2)),
        EntityRow("on_off", _is_on, SWITCH.write, has(8)),
    ),
)

HUMIDIFIER: Final = EntityComponent(
    "x_humidifier",
    (
        SWITCH,
        replace(_HUMIDITY_SETPOINT, when=lambda info: "humidity" in info),
        _MEASURED[1],
        choice("humidifier_mode", "mode", "available_modes", "set_mode", when=has(1)),
    ),
)


def _write_direction(_info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "set_direction", "direction": require_option("direction", value, ("forward", "reverse"))}


FAN: Final = EntityComponent(
    "fan",
    (
        SWITCH,
        replace(
            percent("fan_speed", "percentage", "set_percentage", when=has(1)),
            read=read_while_on("percentage"),
            grid=grid_of("percentage_step"),
        ),
        flag("oscillation", "oscillating", "oscillate", has(2)),
        EntityRow("direction", read_text("direction"), _write_direction, has(4)),
        choice("preset_mode", "preset_mode", "preset_modes", "set_preset_mode", when=has(8)),
    ),
)
