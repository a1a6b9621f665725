"""The services of lamps, plugs, switches, fans, speakers and televisions; the meters of makers. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 (services) and 9 (characteristics): 8.2 Air Purifier,
8.13 Fan, 8.23 Light Bulb, 8.29 Outlet, 8.36 Speaker, 8.38 Switch.
"""

from typing import Final

from homebot.conventions.light_color import MIRED, nearest_mired_bounds
from homebot.conventions.units import number_grid
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.homekit.formats.accessory import HapService
from homebot.integrations.homekit.formats.rows import Writes, service_row

LIGHT, SWITCH, OUTLET, SIMPLE_FAN, FAN, PURIFIER = "43", "49", "47", "40", "B7", "BB"
HEATER, HUMIDIFIER, THERMOSTAT = "BC", "BD", "4A"
SPEAKER, SMART_SPEAKER, TELEVISION = "113", "228", "D8"
ON, ACTIVE, BRIGHTNESS, HUE, SATURATION, MIREDS, SPEED = "25", "B0", "8", "13", "2F", "CE", "29"
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
