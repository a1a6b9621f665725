"""The services that can be commanded: lamps, power, media, openings, locks, alarms, climate; meters of makers. Pure.

A thermostat has one target temperature, and two thresholds that count in the mode ``auto``, if it has them.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 (services) and 9 (characteristics): 8.2 Air Purifier,
8.11 Door, 8.13 Fan, 8.16 Garage Door Opener, 8.18 Heater Cooler, 8.19 Humidifier Dehumidifier, 8.23 Light Bulb, 8.26
Lock Mechanism, 8.29 Outlet, 8.33 Security System, 8.36 Speaker, 8.38 Switch, 8.40 Thermostat, 8.41 Valve, 8.42 Window,
8.43 Window Covering.
"""

from collections.abc import Mapping
from functools import partial
from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.conventions.units import number_grid
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


LIGHT, SWITCH, OUTLET, SIMPLE_FAN, FAN, PURIFIER = "43", "49", "47", "40", "B7", "BB"
SPEAKER, SMART_SPEAKER, TELEVISION = "113", "228", "D8"
ON, BRIGHTNESS, HUE, SATURATION, MIREDS, SPEED = "25", "8", "13", "2F", "CE", "29"
_USUAL_MIREDS: Final = (50.0, 400.0)
_FANS: Final = f"{SIMPLE_FAN} {FAN} {PURIFIER}"
_BLOWERS: Final = f"{_FANS} {HEATER} {HUMIDIFIER}"
_DIRECTIONS: Final = {0: "forward", 1: "reverse"}
_PLAYBACKS: Final = {0: "playing", 1: "paused", 2: "stopped", 4: "buffering"}
_FAN_MODES: Final = {0: "manual", 1: "auto"}
_EVE, _SENSE, _KOOGEEK = "-079E-48FF-8F27-9C2605A29F52", "-0000-1000-8000-001D4B474349", "-0DEC-11E5-B939-0800200C9A66"
_OTHER_POWERS: Final = ("7BBBA96E-EB2D-11E5-A837-0800200C9A66", "FC093458-18F0-4B1D-8360-BB68A3FCC9C5")
_AQARA_VOLUMES: Final = ("EE56B186-B0D3-528E-8C79-C21FC9BCF437", "EE56B186-B0D3-488E-8C79-C21FC9BCF437")
_METERS: Final = {
    "power": (f"E863F10D{_EVE}", f"0000000A{_SENSE}", f"4AAAF931{_KOOGEEK}", *_OTHER_POWERS),
    "energy": (f"E863F10C{_EVE}", f"0000000C{_SENSE}"),
    "voltage": (f"E863F10A{_EVE}", f"00000008{_SENSE}"),
    "current": (f"E863F126{_EVE}", f"00000009{_SENSE}", f"00000004{_SENSE}"),
    "pressure": (f"E863F10F{_EVE}",),
}
"""The types of Eve, ConnectSense, Koogeek and VOCOlinc, under any service, as aiohomekit 4.0 names them."""


def _kelvin_bounds(service: HapService) -> tuple[float, float]:
    least, most = service.characteristics[MIREDS].bounds or _USUAL_MIREDS
    return nearest_mired_bounds(*((least, most) if 25 <= least < most <= 1000 else _USUAL_MIREDS))


def _read_kelvin(service: HapService) -> PlainValue:
    mireds = service.number(MIREDS)
    return float(round(MIRED / mireds)) if mireds is not None and 25 <= mireds <= 1000 else None


def _read_color(service: HapService) -> PlainValue:
    hue, saturation = service.number(HUE), service.number(SATURATION)
    is_known = hue is not None and saturation is not None and 0 <= hue <= 360 and 0 <= saturation <= 100
    return (hue, saturation) if is_known else None  # type: ignore[return-value]  # a number each


def _switch_of(service: HapService) -> str:
    return ON if ON in service.characteristics else ACTIVE


def _turned_on(service: HapService) -> dict[str, float]:
    """Return the values that turn on a light, if it is off: Vimar's dimmers that are on take that for 100 %."""
    switch = _switch_of(service)
    return {} if service.number(switch) == 1 else {switch: 1.0}


def _write_color(service: HapService, command: Command) -> Writes:
    hue, saturation = command.value.numbers
    return {**_turned_on(service), HUE: hue, SATURATION: saturation}


def _share(service: HapService) -> float:
    """Return what one percent of speed is: some fans count their speeds from 0 to 3."""
    bounds = service.characteristics[SPEED].bounds
    return bounds[1] / 100 if bounds and bounds[1] > 0 else 1.0


def _speed_grid(service: HapService) -> tuple[float, ...]:
    return number_grid(0, (service.characteristics[SPEED].step or 1.0) / _share(service))


def _read_speed(service: HapService) -> PlainValue:
    if service.type in _FANS.split() and service.number(_switch_of(service)) == 0:
        return 0.0  # it keeps the speed of before
    speed = service.number(SPEED)
    percent = None if speed is None else round(speed / _share(service), 4)
    return percent if percent is not None and 0 <= percent <= 100 else None


def _write_level(service: HapService, command: Command) -> Writes:
    percent, least = command.value.number, service.characteristics[BRIGHTNESS].step or 1.0
    return {**_turned_on(service), BRIGHTNESS: max(least, percent)} if percent else {ON: 0}


def _write_speed(service: HapService, command: Command) -> Writes:
    """Set a speed: 0 turns a fan off, and another one on; a heater heats on at any."""
    percent, is_fan = command.value.number, service.type in _FANS.split()
    if is_fan and not percent:
        return {_switch_of(service): 0}
    return {**(_turned_on(service) if is_fan else {}), SPEED: percent * _share(service)}


POWER_ROWS: Final = (
    service_row(f"{LIGHT} {SWITCH} {OUTLET} {SIMPLE_FAN}", "on_off", ON, ON),
    service_row(f"{FAN} {PURIFIER} {TELEVISION}", "on_off", ACTIVE, ACTIVE),
    service_row(LIGHT, "level", BRIGHTNESS, BRIGHTNESS, write=_write_level),
    service_row(
        LIGHT,
        "color_temperature",
        MIREDS,
        MIREDS,
        read=_read_kelvin,
        write=lambda service, command: {**_turned_on(service), MIREDS: MIRED / command.value.number},
        bounds=_kelvin_bounds,
        grid=lambda _: (),
    ),
    service_row(LIGHT, "color", f"{HUE} {SATURATION}", HUE, None, _read_color, _write_color),
    service_row(OUTLET, "plugged_in", "26"),
    service_row(
        _BLOWERS,
        "fan_speed",
        f"{SPEED} {ON} {ACTIVE}",
        SPEED,
        None,
        _read_speed,
        _write_speed,
        grid=_speed_grid,
    ),
    service_row(f"{FAN} {THERMOSTAT}", "fan_mode", "BF", "BF", _FAN_MODES),
    service_row(PURIFIER, "fan_mode", "A8", "A8", _FAN_MODES),
    service_row(f"{_FANS} {HEATER}", "oscillation", "B6", "B6"),
    service_row(_FANS, "direction", "28", "28", _DIRECTIONS),
    service_row(f"{SPEAKER} {SMART_SPEAKER}", "volume", "119", "119"),
    service_row("", "muted", "11A", "11A"),  # also of microphones and air purifiers
    service_row(f"{TELEVISION} {SMART_SPEAKER}", "playback", "E0", "137", _PLAYBACKS),
    *(service_row("", "volume", kind, kind) for kind in _AQARA_VOLUMES),
    *(service_row("", name, kind) for name, kinds in _METERS.items() for kind in kinds),
)


GARAGE, COVERING = "41", "8C"
_MOTORS: Final = f"81 8B {COVERING}"
"""Doors, windows and coverings."""

_VALVES: Final = "D0 D7"
"""Valves and faucets."""

IRRIGATION: Final = "CF"

POSITION, POSITION_TARGET, MOVEMENT, HOLD = "6D", "7C", "72", "6F"
_LOCKED: Final = {0: "unlocked", 1: "locked"}
_OPENED: Final = {0: "closed", 1: "open"}
_OPEN: Final = {0: "open", 1: "closed"}
_DOOR_MOVES: Final = {2: "opening", 3: "closing", 4: "stopped"}
_ARMED: Final = {0: "armed_home", 1: "armed_away", 2: "armed_night", 3: "disarmed"}
_MOVES: Final = ("open", "closed", "opening", "closing")
_ORDERS: Final = {"open": {POSITION_TARGET: 100}, "closed": {POSITION_TARGET: 0}, "stopped": {HOLD: 1}}
_CLOSED_ANGLE: Final = 90.0
"""Degrees by which slats turn from open (0) to closed, to either side."""


def _target_row(
    services: str,
    capability: str,
    state: str,
    target: str,
    values: Mapping[int, str],
    moving: Mapping[int, str],
    others: Mapping[int, str],
) -> ServiceRow:
    """Return the row of a state that follows a target.

    Args:
        values: The texts of both.
        moving: The texts, by the target, while they differ.
        others: The texts of further states.
    """

    def read(service: HapService) -> PlainValue:
        now, wanted = service.number(state), service.number(target)
        if now is not None and wanted is not None and now != wanted and {now, wanted} <= values.keys():
            return moving[int(wanted)]
        return None if now is None else {**values, **others}.get(int(now))

    def options(service: HapService) -> tuple[str, ...]:
        return tuple(
            dict.fromkeys([*known_values(service, target, values).values(), *others.values(), *moving.values()])
        )

    return service_row(services, capability, f"{state} {target}", target, values, read, options=options)


def _read_movement(service: HapService) -> PlainValue:
    movement, position = service.number(MOVEMENT), service.number(POSITION)
    if movement in {0, 1} and position != service.number(POSITION_TARGET):  # some never say that they stopped
        return "opening" if movement else "closing"
    return None if position is None else "open" if position else "closed"


def _write_movement(_at: HapService, command: Command) -> Writes:
    return _ORDERS[require_option("movement", command.value.text, _ORDERS)]


def _tilt_row(state: str, target: str) -> ServiceRow:
    def read(service: HapService) -> PlainValue:
        angle = service.number(state)
        return None if angle is None or abs(angle) > _CLOSED_ANGLE else round(100 - abs(angle) / 0.9, 1)

    def write(service: HapService, command: Command) -> Writes:
        angle = _CLOSED_ANGLE * (1 - command.value.number / 100)
        is_negative = (service.number(state) or 0) < 0 or service.characteristics[target].bounds[1:] == (0.0,)
        return {target: -angle if is_negative else angle}

    return service_row(COVERING, "tilt", state, target, None, read, write, grid=lambda _: ())


OPENING_ROWS: Final = (
    _target_row(f"45 {GARAGE}", "lock", "1D", "1E", _LOCKED, {0: "unlocking", 1: "locking"}, {2: "jammed"}),
    _target_row(
        "7E", "alarm", "66", "67", _ARMED, dict.fromkeys(range(3), "arming") | {3: "disarming"}, {4: "triggered"}
    ),
    _target_row(_VALVES, "valve", "D2", "B0", _OPENED, {0: "closing", 1: "opening"}, {}),
    service_row(_VALVES, "valve", "B0", "B0", _OPENED),  # a faucet
    service_row(_VALVES, "number", "D3", "D3", unit="s"),  # for how long it opens
    service_row(IRRIGATION, "on_off", "B0", "B0"),  # whether its programs may water
    service_row(IRRIGATION, "running", "D2"),
    _target_row(GARAGE, "movement", "E", "32", _OPEN, {0: "opening", 1: "closing"}, _DOOR_MOVES),
    service_row(_MOTORS, "position", POSITION, POSITION_TARGET),
    service_row(
        _MOTORS,
        "movement",
        f"{POSITION} {MOVEMENT} {POSITION_TARGET}",
        POSITION_TARGET,
        None,
        _read_movement,
        _write_movement,
        lambda service: (*_MOVES, "stopped") if service.can(HOLD, "pw") else _MOVES,
    ),
    _tilt_row("6C", "7B"),  # horizontal slats
    _tilt_row("6E", "7D"),  # vertical slats
    service_row(f"{_MOTORS} {GARAGE}", "problem", "24"),  # obstructed
)
