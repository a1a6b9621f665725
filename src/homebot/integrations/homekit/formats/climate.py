"""The services of thermostats, heaters, coolers and humidifiers. Pure.

A thermostat has one target temperature, and two thresholds that count in the mode ``auto``, if it has them.

Source: HomeKit Accessory Protocol Specification R2, 8.18 (Heater Cooler), 8.19 (Humidifier Dehumidifier), 8.40
(Thermostat).
"""

from functools import partial
from typing import Final

from homebot.conventions.command_values import require_number
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homekit.formats.accessory import HapService
from homebot.integrations.homekit.formats.rows import ServiceRow, Writes, known_values, read_number, service_row

THERMOSTAT, HEATER, HUMIDIFIER = "4A", "BC", "BD"
TARGET, TEMPERATURE, SETPOINT, HEAT_TO, COOL_TO = "33", "11", "35", "12", "D"
ACTIVE, HEATER_TARGET, HUMIDIFIER_TARGET, DRY_TO, WET_TO = "B0", "B2", "B4", "C9", "CA"
_MODES: Final = {0: "off", 1: "heat", 2: "cool", 3: "auto"}
_ACTIONS: Final = {0: "idle", 1: "heating", 2: "cooling"}
_HEATER_MODES: Final = {0: "auto", 1: "heat", 2: "cool"}
_HEATER_ACTIONS: Final = {0: "off", 1: "idle", 2: "heating", 3: "cooling"}
_ECOBEE_MODE, _ECOBEE_HOLD = "B7DDB9A3-54BB-4572-91D2-F1F5B0510F8C", "1B300BC2-CFFC-47FF-89F9-BD6CCF5F2853"
_VOCOLINC_SPRAY: Final = "69D52519-0A4E-4898-8335-4739F9116D0A"
_HUMIDIFIER_MODES: Final = {0: "auto", 1: "humidify", 2: "dehumidify"}
_HEAT, _COOL, _AUTO = 1, 2, 3
_DRY: Final = 2
_HEATER_AUTO: Final = 0


def _can(mode: int, service: HapService) -> bool:
    return bool(known_values(service, TARGET, {mode: "", _AUTO: ""}))


def _setpoint_of(threshold: str, service: HapService) -> str | None:
    """Return the characteristic of the temperature to heat or cool to in the present mode; None if there is none."""
    other = _COOL if threshold == HEAT_TO else _HEAT
    mode = service.number(TARGET)
    if mode in {_AUTO, other} and threshold in service.characteristics:
        return threshold
    is_of_heating = mode != _COOL and _can(_HEAT, service)
    return SETPOINT if is_of_heating == (threshold == HEAT_TO) else None


def _setpoint_bounds(threshold: str, service: HapService) -> tuple[float, ...]:
    """Return the bounds of any mode; a command is held to those of the present one."""
    known = [service.characteristics[kind].bounds for kind in (SETPOINT, threshold) if kind in service.characteristics]
    ends = [end for bounds in known for end in bounds]
    return (min(ends), max(ends)) if ends else ()


def _check_order(service: HapService, capability: str, kind: str, celsius: float) -> None:
    """Refuse a temperature to heat to above the one to cool to."""
    ends = {end: service.number(end) for end in (HEAT_TO, COOL_TO)} | {kind: celsius}
    low, high = ends[HEAT_TO], ends[COOL_TO]
    if low is not None and high is not None and low > high:
        raise RefusedError(f"{capability} {celsius:g}", f"it would heat to {low:g} °C, and cool to {high:g} °C")


def _heater_setpoint_row(capability: str, threshold: str) -> ServiceRow:
    def write(service: HapService, command: Command) -> Writes:
        if service.number(HEATER_TARGET) == _HEATER_AUTO:
            _check_order(service, capability, threshold, command.value.number)
        return {threshold: command.value.number}

    return service_row(HEATER, capability, threshold, threshold, write=write)


def _setpoint_row(capability: str, threshold: str, mode: int) -> ServiceRow:
    def read(service: HapService) -> PlainValue:
        kind = _setpoint_of(threshold, service)
        return None if kind is None else read_number(capability, kind, service)

    def write(service: HapService, command: Command) -> Writes:
        kind = _setpoint_of(threshold, service)
        if kind is None:
            raise RefusedError(capability, "the thermostat is in another mode; set thermostat_mode first")
        least, most = service.characteristics[kind].bounds or (-50.0, 100.0)
        celsius = require_number(capability, command.value.number, least, most, "°C")
        if service.number(TARGET) == _AUTO:
            _check_order(service, capability, kind, celsius)
        return {kind: celsius}

    watched = f"{SETPOINT} {threshold} {TARGET}"
    return service_row(
        THERMOSTAT,
        capability,
        watched,
        SETPOINT,
        None,
        read,
        write,
        bounds=partial(_setpoint_bounds, threshold),
        when=partial(_can, mode),
    )


def _read_heater_mode(service: HapService) -> PlainValue:
    target = service.number(HEATER_TARGET)
    if service.number(ACTIVE) == 0 or target is None:
        return None if target is None else "off"
    return _HEATER_MODES.get(int(target))


def _write_heater_mode(_at: HapService, command: Command) -> Writes:
    number = next((raw for raw, text in _HEATER_MODES.items() if text == command.value.text), None)
    return {ACTIVE: 0} if number is None else {HEATER_TARGET: number, ACTIVE: 1}


def _humidity_of(service: HapService) -> str:
    dries = service.number(HUMIDIFIER_TARGET) == _DRY and DRY_TO in service.characteristics
    return DRY_TO if dries or WET_TO not in service.characteristics else WET_TO


CLIMATE_ROWS: Final = (
    service_row(f"{THERMOSTAT} {HEATER}", "local_temperature", TEMPERATURE),
    service_row(THERMOSTAT, "thermostat_mode", TARGET, TARGET, _MODES),
    service_row(THERMOSTAT, "thermostat_action", "F", "", _ACTIONS),
    _setpoint_row("heating_setpoint", HEAT_TO, _HEAT),
    _setpoint_row("cooling_setpoint", COOL_TO, _COOL),
    service_row(THERMOSTAT, "humidity_setpoint", "34", "34"),
    service_row(THERMOSTAT, "preset_mode", _ECOBEE_MODE, _ECOBEE_HOLD, {0: "home", 1: "sleep", 2: "away"}),
    service_row(
        HEATER,
        "thermostat_mode",
        f"{HEATER_TARGET} {ACTIVE}",
        HEATER_TARGET,
        None,
        _read_heater_mode,
        _write_heater_mode,
        lambda service: ("off", *known_values(service, HEATER_TARGET, _HEATER_MODES).values()),
    ),
    service_row(HEATER, "thermostat_action", "B1", "", _HEATER_ACTIONS),
    _heater_setpoint_row("heating_setpoint", HEAT_TO),
    _heater_setpoint_row("cooling_setpoint", COOL_TO),
    service_row(HUMIDIFIER, "on_off", ACTIVE, ACTIVE),
    service_row(HUMIDIFIER, "humidifier_mode", HUMIDIFIER_TARGET, HUMIDIFIER_TARGET, _HUMIDIFIER_MODES),
    service_row(
        HUMIDIFIER,
        "humidity_setpoint",
        f"{WET_TO} {DRY_TO} {HUMIDIFIER_TARGET}",
        WET_TO,
        None,
        lambda service: read_number("humidity_setpoint", _humidity_of(service), service),
        lambda service, command: {_humidity_of(service): command.value.number},
        bounds=lambda service: service.characteristics[_humidity_of(service)].bounds or (0.0, 100.0),
    ),
    service_row(HUMIDIFIER, "humidity_setpoint", DRY_TO, DRY_TO),  # if it only dries
    service_row(HUMIDIFIER, "measurement", "B5", unit="%"),  # the level of its water
    service_row(HUMIDIFIER, "number", _VOCOLINC_SPRAY, _VOCOLINC_SPRAY),
)
