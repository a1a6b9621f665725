"""Thermostats, air conditioners, water heaters and fans of ESPHome as rows. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto`` and ``components/climate/climate_mode.h``.
"""

from collections.abc import Callable, Mapping
from typing import Final

from homebot.conventions.command_values import require_bool, require_number, require_option, speed_of
from homebot.conventions.entity_rows import (
    EntityComponent,
    EntityRow,
    Fields,
    ReadField,
    climate_type,
    has_feature,
    options_of,
    switched_mode,
    whole_of,
)
from homebot.conventions.units import celsius_bounds, number_grid, percent_grid, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.integrations.esphome.formats.entity import choice_row, flag_row, listed, number_of, numbers_of, read_named

_MODES = ("off", "heat_cool", "cool", "heat", "fan_only", "dry", "auto")
_ACTIONS = {0: "off", 2: "cooling", 3: "heating", 4: "idle", 5: "drying", 6: "fan", 7: "defrosting"}
_FAN_MODES = ("on", "off", "auto", "low", "medium", "high", "middle", "focus", "diffuse", "quiet")
_SWINGS = ("off", "both", "vertical", "horizontal")
_PRESETS = ("none", "home", "away", "boost", "comfort", "eco", "sleep", "activity")
_WATER_MODES = ("off", "eco", "electric", "performance", "high_demand", "heat_pump", "gas")

_MEASURES, _HAS_PAIR, _ONLY_PAIR, _MEASURES_HUMIDITY, _HAS_HUMIDITY, _HAS_ACTION = 1, 2, 4, 8, 16, 32
_WATER_TARGET, _WATER_SWITCH, _WATER_PAIR, _WATER_ON = 2, 16, 32, 2
_FAHRENHEIT, _KELVIN = 1, 2
_ZERO = 273.15
_ANY_CELSIUS = (-100.0, 200.0)
_MAX_LEVELS = 1000


def _named(names: tuple[str, ...], field: str) -> Callable[[Fields], Mapping[str, object]]:
    """Return the choices of an enum that a list of the description has."""
    return lambda info: {names[number]: number for number in numbers_of(info, field) if 0 <= number < len(names)}


_modes_of = _named(_MODES, "supported_modes")


def _celsius(info: Fields, number: float) -> float:
    unit = whole_of(info, "temperature_unit")
    return {_FAHRENHEIT: to_celsius(number), _KELVIN: round(number - _ZERO, 4)}.get(unit, number)


def _read_celsius(field: str) -> ReadField:
    def read(info: Fields, state: Fields) -> PlainValue:
        number = number_of(state, field)
        return None if number is None else _celsius(info, number)

    return read


def _setpoint_row(
    capability: str, lowest: str, highest: str, step: str, field_of: Callable[[Fields], str]
) -> EntityRow:
    """Return the row of a setpoint; *field_of* returns its field in state and command, empty for none."""

    def bounds(info: Fields) -> tuple[float, float] | tuple[()]:
        low, high = number_of(info, lowest), number_of(info, highest)
        if low is None or high is None or low >= high:
            return ()
        is_fahrenheit = whole_of(info, "temperature_unit") == _FAHRENHEIT
        return celsius_bounds(low, high) if is_fahrenheit else (_celsius(info, low), _celsius(info, high))

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        celsius = require_number(capability, value, *(bounds(info) or _ANY_CELSIUS), "°C")
        unit, low, high = whole_of(info, "temperature_unit"), number_of(info, lowest), number_of(info, highest)
        number = {_FAHRENHEIT: to_fahrenheit(celsius), _KELVIN: celsius + _ZERO}.get(unit, celsius)
        number = min(max(number, low), high) if low is not None and high is not None else number
        return {field_of(info): number}

    def read(info: Fields, state: Fields) -> PlainValue:
        return _read_celsius(field_of(info))(info, state)

    def grid(info: Fields) -> tuple[float, ...]:
        return number_grid(0, number_of(info, step), is_fahrenheit=whole_of(info, "temperature_unit") == _FAHRENHEIT)

    return EntityRow(capability, read, write, field_of, (), bounds, "°C", grid)


def _has_pair(info: Fields) -> bool:
    """Return whether it has a pair of targets.

    With either flag of a pair, ESPHome refuses the single target in every mode (``ClimateCall::validate_``).
    """
    return bool(whole_of(info, "feature_flags") & (_HAS_PAIR | _ONLY_PAIR))


def _cools(info: Fields) -> bool:
    return not _modes_of(info).keys().isdisjoint({"cool", "heat_cool"})


def _heating_field(info: Fields) -> str:
    if _has_pair(info):
        return "target_temperature_low"
    heats = not _modes_of(info).keys().isdisjoint({"heat", "heat_cool", "auto"})
    return "target_temperature" if heats or not _cools(info) else ""


def _cooling_field(info: Fields) -> str:
    single = "target_temperature" if _cools(info) else ""
    return "target_temperature_high" if _has_pair(info) else single


def _water_field(info: Fields) -> str:
    flags = whole_of(info, "supported_features")
    single = "target_temperature" if flags & _WATER_TARGET else ""
    return "target_temperature_low" if flags & _WATER_PAIR else single


def _read_humidity(field: str) -> ReadField:
    def read(_info: Fields, state: Fields) -> PlainValue:
        number = number_of(state, field)
        return number if number is not None and 0 <= number <= 100 else None

    return read


def _read_on(_info: Fields, state: Fields) -> PlainValue:
    mode = state.get("mode")
    return mode != _MODES.index("off") if isinstance(mode, int) else None


def _write_on(info: Fields, value: PlainValue, _code: str) -> Fields:
    """Switch by means of the mode, as Home Assistant does."""
    modes = _modes_of(info)
    return {"mode": modes[switched_mode(modes, value)]}


def _named_row(name: str, field: str, names: tuple[str, ...], standard: str, custom: str) -> EntityRow:
    """Return the row of standard modes, which are numbers, and custom modes, which are texts in another field."""
    known_of = _named(names, standard)

    def options(info: Fields) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*known_of(info), *options_of(info, custom))))

    def read(info: Fields, state: Fields) -> PlainValue:
        own, number = state.get(f"custom_{field}"), state.get(field)
        if isinstance(own, str) and own:
            return own if own in options(info) else None
        return names[number] if isinstance(number, int) and 0 <= number < len(names) else None

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        known, option = known_of(info), require_option(name, value, options(info))
        return {field: known[option]} if option in known else {f"custom_{field}": option}

    return EntityRow(name, read, write, options, options)


_VISUAL = ("visual_min_temperature", "visual_max_temperature", "visual_target_temperature_step")
_WATER = ("min_temperature", "max_temperature", "target_temperature_step")

CLIMATE: Final = EntityComponent(
    lambda info: climate_type(_modes_of(info)),
    (
        _setpoint_row("heating_setpoint", *_VISUAL, _heating_field),
        _setpoint_row("cooling_setpoint", *_VISUAL, _cooling_field),
        EntityRow(
            "local_temperature",
            _read_celsius("current_temperature"),
            when=has_feature("feature_flags", _MEASURES),
            unit="°C",
        ),
        EntityRow(
            "humidity", _read_humidity("current_humidity"), when=has_feature("feature_flags", _MEASURES_HUMIDITY)
        ),
        EntityRow(
            "humidity_setpoint",
            _read_humidity("target_humidity"),
            lambda _info, value, _code: {"target_humidity": require_number("humidity_setpoint", value, 0, 100, "%")},
            when=has_feature("feature_flags", _HAS_HUMIDITY),
        ),
        choice_row("thermostat_mode", "mode", _modes_of),
        EntityRow("on_off", _read_on, _write_on, when=lambda info: "off" in _modes_of(info)),
        EntityRow("thermostat_action", read_named("action", _ACTIONS), when=has_feature("feature_flags", _HAS_ACTION)),
        _named_row("fan_mode", "fan_mode", _FAN_MODES, "supported_fan_modes", "supported_custom_fan_modes"),
        _named_row("preset_mode", "preset", _PRESETS, "supported_presets", "supported_custom_presets"),
        choice_row("swing_mode", "swing_mode", _named(_SWINGS, "supported_swing_modes")),
    ),
)

WATER_HEATER: Final = EntityComponent(
    "water_heater",
    (
        _setpoint_row("heating_setpoint", *_WATER, _water_field),
        EntityRow(
            "local_temperature",
            _read_celsius("current_temperature"),
            when=has_feature("supported_features", _MEASURES),
            unit="°C",
        ),
        choice_row("water_heater_mode", "mode", _named(_WATER_MODES, "supported_modes")),
        EntityRow(
            "on_off",
            lambda _info, state: bool(whole_of(state, "state") & _WATER_ON),
            lambda _info, value, _code: {"on": require_bool("on_off", value)},
            when=has_feature("supported_features", _WATER_SWITCH),
        ),
    ),
)


def _speed_levels(info: Fields) -> int:
    """Return the number of speeds; 0 if it has none or too many."""
    levels = int(number_of(info, "supported_speed_count") or 0) if info.get("supports_speed") is True else 0
    return levels if 0 < levels <= _MAX_LEVELS else 0


def _directions(info: Fields) -> Mapping[str, object]:
    return {"forward": 0, "reverse": 1} if info.get("supports_direction") is True else {}


def _speed_grid(info: Fields) -> tuple[float, ...]:
    return percent_grid(_speed_levels(info))


def _read_speed(info: Fields, state: Fields) -> PlainValue:
    """Read the speed; ESPHome counts from 1 to the number of levels."""
    level, levels = number_of(state, "speed_level"), _speed_levels(info)
    if state.get("state") is False:
        return 0.0
    return None if level is None or not 0 <= level <= levels else round(level * 100 / levels, 4)


def _write_speed(info: Fields, value: PlainValue, _code: str) -> Fields:
    percent = require_number("fan_speed", value, 0, 100, "%")
    level = speed_of(percent, _speed_levels(info))
    return {"state": True, "speed_level": level} if level else {"state": False}


FAN: Final = EntityComponent(
    "fan",
    (
        flag_row("on_off", "state"),
        EntityRow("fan_speed", _read_speed, _write_speed, _speed_levels, grid=_speed_grid),
        flag_row("oscillation", "oscillating", "supports_oscillation"),
        choice_row("direction", "direction", _directions),
        choice_row("preset_mode", "preset_mode", listed("supported_preset_modes")),
    ),
)
