"""Thermostats, air conditioners, water heaters and fans of ESPHome. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto`` and ``components/climate/climate_mode.h``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.esphome.entity import (
    EsphomeEntity,
    Fields,
    number_of,
    numbers_of,
    options_of,
    table_reader,
    whole_of,
)
from homebot.conventions.units import celsius_bounds, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["build_climate", "build_fan", "build_water_heater"]

_MODES = ("off", "heat_cool", "cool", "heat", "fan_only", "dry", "auto")
_ACTIONS: Mapping[object, str] = {
    0: "off",
    2: "cooling",
    3: "heating",
    4: "idle",
    5: "drying",
    6: "fan",
    7: "defrosting",
}
_FAN_MODES = ("on", "off", "auto", "low", "medium", "high", "middle", "focus", "diffuse", "quiet")
_SWINGS = ("off", "both", "vertical", "horizontal")
_PRESETS = ("none", "home", "away", "boost", "comfort", "eco", "sleep", "activity")
_WATER_MODES = ("off", "eco", "electric", "performance", "high_demand", "heat_pump", "gas")

_MEASURES, _HAS_PAIR, _ONLY_PAIR, _MEASURES_HUMIDITY, _HAS_HUMIDITY, _HAS_ACTION = 1, 2, 4, 8, 16, 32


def build_climate(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a thermostat; an air conditioner if it cools and can also dry or only ventilate."""
    flags = whole_of(info, "feature_flags")
    modes = _named(_MODES, numbers_of(info, "supported_modes"))
    is_conditioner = "cool" in modes and ("dry" in modes or "fan_only" in modes)
    entity = EsphomeEntity(kind, info, "room_air_conditioner" if is_conditioner else "thermostat")
    _add_targets(entity, _Thermometer(info, "visual_min_temperature", "visual_max_temperature"), flags, modes)
    if flags & _MEASURES:
        thermometer = _Thermometer(info)
        entity.add("local_temperature", thermometer.reader("current_temperature"), unit="°C")
    if flags & _MEASURES_HUMIDITY:
        entity.add("humidity", lambda state: _percent(state, "current_humidity"))
    if flags & _HAS_HUMIDITY:
        entity.add(
            "humidity_setpoint",
            lambda state: _percent(state, "target_humidity"),
            lambda value, _code: {"target_humidity": require_number("humidity_setpoint", value, 0, 100, "%")},
        )
    if modes:
        entity.add_choice("thermostat_mode", "mode", modes)
        _add_switch(entity, modes)
    if flags & _HAS_ACTION:
        entity.add("thermostat_action", table_reader("action", _ACTIONS))
    _add_named(entity, "fan_mode", "fan_mode", _FAN_MODES, ("supported_fan_modes", "supported_custom_fan_modes"))
    _add_named(entity, "preset_mode", "preset", _PRESETS, ("supported_presets", "supported_custom_presets"))
    swings = _named(_SWINGS, numbers_of(info, "supported_swing_modes"))
    if swings:
        entity.add_choice("swing_mode", "swing_mode", swings)
    return entity


def build_water_heater(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a water heater."""
    flags = whole_of(info, "supported_features")
    entity = EsphomeEntity(kind, info, "water_heater")
    thermometer = _Thermometer(info, "min_temperature", "max_temperature")
    field = "target_temperature_low" if flags & _WATER_PAIR else "target_temperature"
    if flags & (_WATER_TARGET | _WATER_PAIR):
        entity.add(
            "heating_setpoint",
            thermometer.reader(field),
            lambda value, _code: {field: thermometer.number("heating_setpoint", value)},
            unit="°C",
            bounds=thermometer.bounds,
        )
    if flags & _MEASURES:
        entity.add("local_temperature", thermometer.reader("current_temperature"), unit="°C")
    modes = _named(_WATER_MODES, numbers_of(info, "supported_modes"))
    if modes:
        entity.add_choice("water_heater_mode", "mode", modes)
    if flags & _WATER_SWITCH:
        entity.add(
            "on_off",
            lambda state: bool(whole_of(state, "state") & _WATER_ON),
            lambda value, _code: {"on": require_bool("on_off", value)},
        )
    return entity


_WATER_TARGET, _WATER_SWITCH, _WATER_PAIR, _WATER_ON = 2, 16, 32, 2


def build_fan(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a fan; ESPHome counts its speeds from 1 to the number of levels."""
    entity = EsphomeEntity(kind, info, "fan")
    entity.add_flag("on_off", "state")
    levels = int(number_of(info, "supported_speed_count") or 0)
    if info.get("supports_speed") is True and 0 < levels <= _MOST_LEVELS:

        def read(state: Fields) -> PlainValue:
            level = number_of(state, "speed_level")
            if state.get("state") is False:
                return 0.0
            return None if level is None or not 0 <= level <= levels else round(level * 100 / levels, 4)

        def write(value: PlainValue, _code: str) -> Fields:
            percent = require_number("fan_speed", value, 0, 100, "%")
            level = math.ceil(round(percent * levels / 100, 4))
            return {"state": True, "speed_level": level} if level else {"state": False}

        entity.add("fan_speed", read, write)
    if info.get("supports_oscillation") is True:
        entity.add_flag("oscillation", "oscillating")
    if info.get("supports_direction") is True:
        entity.add_choice("direction", "direction", {"forward": 0, "reverse": 1})
    presets = options_of(info, "supported_preset_modes")
    if presets:
        entity.add_choice("preset_mode", "preset_mode", {one: one for one in presets})
    return entity


_MOST_LEVELS = 1000


class _Thermometer:
    """The temperature unit of a device, with its lowest and highest target.

    Attributes:
        bounds: The two in °C; empty if it names none.
    """

    def __init__(self, info: Fields, low: str = "", high: str = "") -> None:
        self._unit = whole_of(info, "temperature_unit")
        self._low, self._high = number_of(info, low), number_of(info, high)
        self.bounds: tuple[float, float] | tuple[()] = ()
        if self._low is not None and self._high is not None and self._low < self._high:
            low_celsius, high_celsius = self._celsius(self._low), self._celsius(self._high)
            is_fahrenheit = self._unit == _FAHRENHEIT
            self.bounds = celsius_bounds(self._low, self._high) if is_fahrenheit else (low_celsius, high_celsius)

    def reader(self, field: str) -> Callable[[Fields], PlainValue]:
        """Return a reader of a temperature."""

        def read(state: Fields) -> PlainValue:
            number = number_of(state, field)
            return None if number is None else self._celsius(number)

        return read

    def number(self, name: str, value: PlainValue) -> float:
        """Return a target in the unit of the device."""
        least, most = self.bounds or _ANY_CELSIUS
        celsius = require_number(name, value, least, most, "°C")
        number = {_FAHRENHEIT: to_fahrenheit(celsius), _KELVIN: celsius + _ZERO}.get(self._unit, celsius)
        return min(max(number, self._low), self._high) if self._low is not None and self._high is not None else number

    def _celsius(self, number: float) -> float:
        return {_FAHRENHEIT: to_celsius(number), _KELVIN: round(number - _ZERO, 4)}.get(self._unit, number)


_FAHRENHEIT, _KELVIN = 1, 2
_ZERO = 273.15
_ANY_CELSIUS = (-100.0, 200.0)


def _add_targets(entity: EsphomeEntity, thermometer: _Thermometer, flags: int, modes: Mapping[str, object]) -> None:
    """Offer the targets: of a pair the lower one heats and the upper one cools; a single one follows its modes.

    With either flag of a pair, ESPHome refuses the single target in every mode (``ClimateCall::validate_``).
    """
    has_pair = bool(flags & (_HAS_PAIR | _ONLY_PAIR))
    heats = not modes or not modes.keys().isdisjoint({"heat", "heat_cool", "auto"})
    cools = not modes.keys().isdisjoint({"cool", "heat_cool"})
    for name, target in _PAIR.items():
        field = target if has_pair else "target_temperature"
        if has_pair or (name == "cooling_setpoint" and cools) or (name == "heating_setpoint" and (heats or not cools)):
            entity.add(
                name,
                thermometer.reader(field),
                lambda value, _code, name=name, field=field: {field: thermometer.number(name, value)},  # type: ignore[misc]
                unit="°C",
                bounds=thermometer.bounds,
            )


_PAIR = {"heating_setpoint": "target_temperature_low", "cooling_setpoint": "target_temperature_high"}


def _add_switch(entity: EsphomeEntity, modes: Mapping[str, object]) -> None:
    """Add on and off by means of the mode, as Home Assistant does."""
    on = next((one for one in ("heat_cool", "heat", "cool", *modes) if one in modes and one != "off"), "")
    wanted = ({True: modes[on]} if on else {}) | ({False: modes["off"]} if "off" in modes else {})

    def write(value: PlainValue, _code: str) -> Fields:
        is_on = require_bool("on_off", value)
        if is_on not in wanted:
            raise RefusedError(f"on_off {value}", f"none of its modes is that: {', '.join(modes)}")
        return {"mode": wanted[is_on]}

    def read(state: Fields) -> PlainValue:
        mode = state.get("mode")
        return mode != modes["off"] if isinstance(mode, int) else None

    entity.add("on_off", read if "off" in modes else None, write)


def _add_named(entity: EsphomeEntity, name: str, field: str, names: tuple[str, ...], lists: tuple[str, str]) -> None:
    """Add a choice of standard modes, which are numbers, and custom modes, which are texts in a field of their own."""
    known = _named(names, numbers_of(entity.info, lists[0]))
    own_field = f"custom_{field}"
    options = tuple(dict.fromkeys((*known, *options_of(entity.info, lists[1]))))

    def read(state: Fields) -> PlainValue:
        own = state.get(own_field)
        if isinstance(own, str) and own:
            return own if own in options else None
        number = state.get(field)
        return names[number] if isinstance(number, int) and 0 <= number < len(names) else None

    def write(value: PlainValue, _code: str) -> Fields:
        option = require_option(name, value, options)
        return {field: known[option]} if option in known else {own_field: option}

    if options:
        entity.add(name, read, write, options=options)


def _named(names: tuple[str, ...], numbers: tuple[int, ...]) -> dict[str, object]:
    return {names[number]: number for number in numbers if 0 <= number < len(names)}


def _percent(state: Fields, name: str) -> PlainValue:
    number = number_of(state, name)
    return number if number is not None and 0 <= number <= 100 else None
