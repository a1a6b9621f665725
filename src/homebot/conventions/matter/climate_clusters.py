"""The clusters of heating and air: Thermostat and Fan Control. Pure.

Source: Matter 1.4 Application Clusters, 4.3 (Thermostat), 4.4 (Fan Control).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.matter.endpoint import AttributeWrite, MatterAbility, MatterEndpoint, MatterOrder
from homebot.conventions.matter.light_clusters import ON_OFF
from homebot.conventions.matter.thermostat_presets import preset_abilities
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["climate_abilities"]

THERMOSTAT, FAN = 513, 514

_LOCAL, _COOLING, _HEATING = 0, 0x11, 0x12
_SYSTEM_MODE, _RUNNING_STATE = 0x1C, 0x29
_LIMITS: Final = {_HEATING: ((0x15, 0x16), (3, 4)), _COOLING: ((0x17, 0x18), (5, 6))}
"""Of each setpoint: the attributes of the limits that people set, and of those of the device."""

_HEATS, _COOLS, _CHANGES_BY_ITSELF = 1 << 0, 1 << 1, 1 << 5
_CONTROL_SEQUENCE: Final = 0x1B
_SEQUENCE_FEATURES: Final = {0: 2, 1: 2, 2: 1, 3: 1, 4: 3, 5: 3}
"""By the control sequence, of devices that have no feature map."""

_MODES: Final = {0: "off", 1: "auto", 3: "cool", 4: "heat", 5: "emergency_heat", 6: "precooling", 7: "fan_only"}
_MODES_ALL: Final = {**_MODES, 8: "dry", 9: "sleep"}
_MODE_NUMBERS: Final = {name: number for number, name in _MODES_ALL.items()}
_UNKNOWN: Final = -32_768

_FAN_MODE, _FAN_SEQUENCE, _FAN_SETTING, _FAN_PERCENT, _AIRFLOW = 0, 1, 2, 3, 11
_ROCK_SUPPORT, _ROCK = 7, 8
_FAN_MODES: Final = {0: "off", 1: "low", 2: "medium", 3: "high", 4: "on", 5: "auto", 6: "smart"}
_FAN_NUMBERS: Final = {name: number for number, name in _FAN_MODES.items()}
_SEQUENCES: Final = {
    0: ("off", "low", "medium", "high"),
    1: ("off", "low", "high"),
    2: ("off", "low", "medium", "high", "auto"),
    3: ("off", "low", "high", "auto"),
    4: ("off", "high", "auto"),
    5: ("off", "high"),
}
_ROCKS, _TURNS_AROUND = 1 << 2, 1 << 5


def climate_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield the setpoints, modes and speeds that the endpoint has."""
    if endpoint.has(THERMOSTAT):
        yield from _thermostat_abilities(endpoint)
        yield from preset_abilities(endpoint)
    if endpoint.has(FAN):
        yield from _fan_abilities(endpoint)


def _thermostat_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    features = endpoint.features(THERMOSTAT)
    if endpoint.has(THERMOSTAT, _LOCAL):
        yield MatterAbility(THERMOSTAT, Capability(name="local_temperature"), _hundredths_reader(_LOCAL))
    for name, attribute, feature in (("heating_setpoint", _HEATING, _HEATS), ("cooling_setpoint", _COOLING, _COOLS)):
        if endpoint.has(THERMOSTAT, attribute) and (not features or features & feature):
            capability = Capability(name=name, settable=True, bounds=_setpoint_bounds(endpoint, attribute))
            yield MatterAbility(
                THERMOSTAT, capability, _hundredths_reader(attribute), partial(_write_setpoint, name, attribute)
            )
    if endpoint.has(THERMOSTAT, _SYSTEM_MODE):
        features = features or _SEQUENCE_FEATURES.get(endpoint.whole(THERMOSTAT, _CONTROL_SEQUENCE) or 0, 0)
        modes = ["off"]
        modes += ["heat"] if features & _HEATS else []
        modes += ["cool"] if features & _COOLS else []
        modes += ["auto"] if features & _CHANGES_BY_ITSELF else []
        capability = Capability(name="thermostat_mode", settable=True, options=tuple(modes))
        yield MatterAbility(THERMOSTAT, capability, _read_mode, _write_mode)
    if endpoint.has(THERMOSTAT, _RUNNING_STATE):
        yield MatterAbility(THERMOSTAT, Capability(name="thermostat_action"), _read_action)


def _hundredths_reader(attribute: int) -> Callable[[MatterEndpoint], PlainValue]:
    def read(endpoint: MatterEndpoint) -> PlainValue:
        value = endpoint.number(THERMOSTAT, attribute)
        return None if value is None or value <= _UNKNOWN or value > 32_767 else value / 100

    return read


def _setpoint_bounds(endpoint: MatterEndpoint, attribute: int) -> tuple[float, ...]:
    for low, high in _LIMITS[attribute]:
        least, most = endpoint.number(THERMOSTAT, low), endpoint.number(THERMOSTAT, high)
        if least is not None and most is not None and _UNKNOWN < least < most <= 32_767:
            return least / 100, most / 100
    return (7.0, 30.0) if attribute == _HEATING else (16.0, 32.0)


def _write_setpoint(
    name: str, attribute: int, endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    least, most = _setpoint_bounds(endpoint, attribute)
    celsius = require_number(name, value, least, most, "°C")
    return (AttributeWrite(THERMOSTAT, attribute, round(celsius * 100)),)


def _read_mode(endpoint: MatterEndpoint) -> PlainValue:
    mode = endpoint.whole(THERMOSTAT, _SYSTEM_MODE)
    return None if mode is None else _MODES_ALL.get(mode)


def _write_mode(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    mode = require_option("thermostat_mode", value, _MODE_NUMBERS)
    return (AttributeWrite(THERMOSTAT, _SYSTEM_MODE, _MODE_NUMBERS[mode]),)


def _read_action(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(THERMOSTAT, _RUNNING_STATE)
    if state is None:
        return None
    if state & 0b0_1001:
        return "heating"
    if state & 0b1_0010:
        return "cooling"
    if state & 0b110_0100:
        return "fan"
    return "off" if endpoint.whole(THERMOSTAT, _SYSTEM_MODE) == 0 else "idle"


def _fan_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    if not endpoint.has(ON_OFF) and endpoint.has(FAN, _FAN_MODE):
        yield MatterAbility(FAN, Capability(name="on_off", settable=True), _read_fan_on, _write_fan_on)
    if endpoint.has(FAN, _FAN_SETTING):
        yield MatterAbility(FAN, Capability(name="fan_speed", settable=True), _read_speed, _write_speed)
    if endpoint.has(FAN, _FAN_MODE):
        options = _SEQUENCES.get(endpoint.whole(FAN, _FAN_SEQUENCE) or 0, _SEQUENCES[0])
        yield MatterAbility(
            FAN, Capability(name="fan_mode", settable=True, options=options), _read_fan_mode, _write_fan_mode
        )
    if endpoint.features(FAN) & _ROCKS and endpoint.has(FAN, _ROCK):
        yield MatterAbility(FAN, Capability(name="oscillation", settable=True), _read_rock, _write_rock)
    if endpoint.features(FAN) & _TURNS_AROUND and endpoint.has(FAN, _AIRFLOW):
        capability = Capability(name="direction", settable=True, options=("forward", "reverse"))
        yield MatterAbility(FAN, capability, _read_direction, _write_direction)


def _read_fan_on(endpoint: MatterEndpoint) -> PlainValue:
    mode = endpoint.whole(FAN, _FAN_MODE)
    return None if mode is None else mode != 0


def _write_fan_on(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    if value is not True:
        return (AttributeWrite(FAN, _FAN_MODE, 0),)
    if endpoint.whole(FAN, _FAN_MODE):
        return ()  # it is on; another mode would change its speed
    return (AttributeWrite(FAN, _FAN_MODE, _FAN_NUMBERS["high"]),)


def _read_speed(endpoint: MatterEndpoint) -> PlainValue:
    if endpoint.whole(FAN, _FAN_MODE) == 0:
        return 0.0  # some keep the speed of before
    for attribute in (_FAN_PERCENT, _FAN_SETTING):
        percent = endpoint.number(FAN, attribute)
        if percent is not None and 0 <= percent <= 100:
            return percent
    return None


def _write_speed(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    return (AttributeWrite(FAN, _FAN_SETTING, round(require_number("fan_speed", value, 0.0, 100.0, "%"))),)


def _read_fan_mode(endpoint: MatterEndpoint) -> PlainValue:
    mode = endpoint.whole(FAN, _FAN_MODE)
    return None if mode is None else _FAN_MODES.get(mode)


def _write_fan_mode(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    return (AttributeWrite(FAN, _FAN_MODE, _FAN_NUMBERS[require_option("fan_mode", value, _FAN_NUMBERS)]),)


def _read_rock(endpoint: MatterEndpoint) -> PlainValue:
    rock = endpoint.whole(FAN, _ROCK)
    return None if rock is None else rock != 0


def _write_rock(endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    supported = endpoint.whole(FAN, _ROCK_SUPPORT) or 1
    return (AttributeWrite(FAN, _ROCK, supported if value is True else 0),)


def _read_direction(endpoint: MatterEndpoint) -> PlainValue:
    return {0: "forward", 1: "reverse"}.get(endpoint.whole(FAN, _AIRFLOW) or 0)


def _write_direction(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    return (AttributeWrite(FAN, _AIRFLOW, 1 if value == "reverse" else 0),)
