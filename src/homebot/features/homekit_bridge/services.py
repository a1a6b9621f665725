"""The services of HomeKit for parts of devices: which there are, their values, and the settings for what is written.

A value is that of the characteristic of its name, as HAP-python spells it; None while the device has not reported it.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 (services) and 9 (characteristics).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from homebot.conventions.light_color import MIRED
from homebot.devices.device import Device, DevicePart
from homebot.devices.part import Capability

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

HapValue: TypeAlias = bool | int | float
Capabilities: TypeAlias = Mapping[str, Capability]
Written: TypeAlias = Mapping[str, HapValue]
_Values: TypeAlias = "Mapping[str, PlainValue]"
_Settings: TypeAlias = "dict[str, PlainValue]"
_Shown: TypeAlias = Mapping[str, "HapValue | None"]

_OFF, _HEAT, _COOL, _AUTO = range(4)
_MODES: Final = {"off": _OFF, "heat": _HEAT, "cool": _COOL, "auto": _AUTO, "heat_cool": _AUTO}
_CLOSED_ANGLE: Final = 90
"""Degrees by which slats turn from open (0) to closed."""

_LOW_BATTERY: Final = 20.0
_NOT_CHARGEABLE, _STOPPED = 2, 2
_LUX: Final = (0.0001, 100_000.0)
_USUAL_DEGREES: Final = (5.0, 35.0)
_USUAL_MIREDS: Final = (140, 500)


class PartValues(NamedTuple):
    """The values of a part.

    Attributes:
        now: The reported values by capability; None for unknown ones.
        wanted: Those of commands that have no outcome yet.
    """

    capabilities: Capabilities
    now: _Values
    wanted: _Values

    def number(self, capability: str) -> float | None:
        """Return a reported number; None if it is unknown."""
        value = self.now.get(capability)
        return value if isinstance(value, float) else None

    def takes(self, capability: str) -> bool:
        """Return whether it can be set."""
        return capability in self.capabilities and self.capabilities[capability].settable


class ServiceKind(NamedTuple):
    """A service of HomeKit.

    Attributes:
        name: Its name in HAP-python.
        characteristics: The names of its characteristics, each with the capabilities that it needs.
        read: Returns their values, perhaps with others.
        write: Returns the settings for written values; None for a sensor.
    """

    name: str
    characteristics: Mapping[str, str]
    read: Callable[[PartValues], _Shown]
    write: Callable[[Written, PartValues], _Settings] | None = None


class PartService(NamedTuple):
    """A service of one part.

    Attributes:
        key: Unique in the device, and permanent: from it follow the numbers in HomeKit.
        part: The id of the part.
        title: Its own name; empty if it has none.
    """

    key: str
    part: str
    title: str
    kind: ServiceKind
    capabilities: Capabilities

    def characteristics(self) -> dict[str, dict[str, object]]:
        """Return the names of its characteristics, with the properties in which they differ from the standard."""
        return {
            name: _properties(name, self.capabilities)
            for name, needed in self.kind.characteristics.items()
            if self.capabilities.keys() >= {*needed.split()}
        }


def services_of(device: Device, parts: Iterable[DevicePart]) -> Iterator[PartService]:
    """Yield the services for *parts* of *device*, and that of its battery if there are any."""
    has_any = False
    for part in parts:
        capabilities = {capability.name: capability for capability in part.part.capabilities}
        main, needs = _KINDS.get(part.part.service_type, (None, ()))
        kinds = [main] if main is not None and not capabilities.keys().isdisjoint(needs) else []
        for kind in (*kinds, *(kind for name, kind in _SENSORS.items() if name in capabilities)):
            has_any = True
            yield PartService(f"{part.id}/{kind.name}", part.id, part.part.name, kind, capabilities)
    for part in device.parts if has_any else ():
        capabilities = {capability.name: capability for capability in part.part.capabilities}
        if not capabilities.keys().isdisjoint(("battery", "battery_low")):
            yield PartService("battery", part.id, "", _BATTERY, capabilities)
            return


def _properties(characteristic: str, capabilities: Capabilities) -> dict[str, object]:
    if characteristic == "ColorTemperature":
        kelvins = capabilities["color_temperature"].bounds
        coldest, warmest = (round(MIRED / kelvin) for kelvin in reversed(kelvins)) if kelvins else _USUAL_MIREDS
        return {"minValue": coldest, "maxValue": warmest}
    if characteristic in {"TargetTemperature", "HeatingThresholdTemperature", "CoolingThresholdTemperature"}:
        ends = [end for name in _setpoints(capabilities) for end in capabilities[name].bounds] or _USUAL_DEGREES
        return {"minValue": min(ends), "maxValue": max(ends), "minStep": 0.5}
    if characteristic == "TargetHeatingCoolingState":
        return {"ValidValues": {f"mode {mode}": mode for mode in sorted({*_modes(capabilities).values()})}}
    return {"minValue": 0, "maxValue": _CLOSED_ANGLE} if characteristic.endswith("TiltAngle") else {}


def _is_on(values: PartValues) -> bool | None:
    on, level = values.now.get("on_off"), values.number("level")
    return on if isinstance(on, bool) else None if level is None else level > 0


def _power(values: PartValues, *, on: bool) -> _Settings:
    return {"on_off": on} if values.takes("on_off") else {"level": 100.0 if on else 0.0}


def _write_power(written: Written, values: PartValues) -> _Settings:
    return _power(values, on=bool(written["On"])) if "On" in written else {}


def _read_light(values: PartValues) -> _Shown:
    kelvin, color = values.number("color_temperature"), values.now.get("color")
    hue, saturation = color if isinstance(color, tuple) else (None, None)
    mireds = round(MIRED / kelvin) if kelvin else None
    on, level = _is_on(values), values.number("level")
    return {"On": on, "Brightness": level, "ColorTemperature": mireds, "Hue": hue, "Saturation": saturation}


def _write_light(written: Written, values: PartValues) -> _Settings:
    """Return one command; what has a brightness turns on by itself."""
    if not (written.get("On", True) and written.get("Brightness", 1)):
        return _power(values, on=False)
    settings: _Settings = {}
    if "Hue" in written or "Saturation" in written:
        both = {**_read_light(values), **written}
        settings["color"] = (float(both["Hue"] or 0), float(both["Saturation"] or 0))
    elif "ColorTemperature" in written:
        kelvin = MIRED / float(written["ColorTemperature"])
        least, most = values.capabilities["color_temperature"].bounds or (kelvin, kelvin)
        settings["color_temperature"] = min(max(kelvin, least), most)
    if "Brightness" in written:
        settings["level"] = float(written["Brightness"])
    elif not settings or not _is_on(values):
        settings = {**_power(values, on=True), **settings}
    return settings


def _position(values: _Values) -> float | None:
    position = values.get("position")
    ends = {"open": 100.0, "opening": 100.0, "closed": 0.0, "closing": 0.0}
    return position if isinstance(position, float) else ends.get(str(values.get("movement")))


def _angle(tilt: object) -> int | None:
    return round(_CLOSED_ANGLE * (1 - tilt / 100)) if isinstance(tilt, float) else None


def _read_cover(values: PartValues) -> _Shown:
    position, wanted, tilt = _position(values.now), _position(values.wanted), values.now.get("tilt")
    target = position if wanted is None else wanted
    moving = {"opening": 1, "closing": 0}.get(str(values.now.get("movement")), _STOPPED)
    if "movement" not in values.capabilities and position is not None and target is not None and position != target:
        moving = int(target > position)
    return {
        "CurrentPosition": position,
        "TargetPosition": target,
        "PositionState": moving,
        "HoldPosition": False,
        "CurrentHorizontalTiltAngle": _angle(tilt),
        "TargetHorizontalTiltAngle": _angle(values.wanted.get("tilt", tilt)),
    }


def _write_cover(written: Written, values: PartValues) -> _Settings:
    if written.get("HoldPosition"):
        return {"movement": "stopped"}
    settings: _Settings = {}
    if "TargetPosition" in written:
        settings = _moved(float(written["TargetPosition"]), values, "position")
    if "TargetHorizontalTiltAngle" in written:
        settings["tilt"] = round(100 * (1 - float(written["TargetHorizontalTiltAngle"]) / _CLOSED_ANGLE), 1)
    return settings


def _moved(position: float, values: PartValues, first: str) -> _Settings:
    """Return how to move there, by the capability *first* if it can be set."""
    is_by_position = values.takes("position") and (first == "position" or not values.takes("movement"))
    return {"position": position} if is_by_position else {"movement": "open" if position >= 50 else "closed"}


def _read_garage(values: PartValues) -> _Shown:
    position, wanted = _position(values.now), _position(values.wanted)
    states = {"open": 0, "closed": 1, "opening": 2, "closing": 3, "stopped": 4}
    state = states.get(str(values.now.get("movement")), None if position is None else int(position == 0))
    target = None if state is None else int(state in {1, 3})
    target = target if wanted is None else int(wanted == 0)
    return {"CurrentDoorState": state, "TargetDoorState": target, "ObstructionDetected": False}


def _write_garage(written: Written, values: PartValues) -> _Settings:
    if "TargetDoorState" not in written:
        return {}
    return _moved(0.0 if written["TargetDoorState"] else 100.0, values, "movement")


def _read_lock(values: PartValues) -> _Shown:
    state = str(values.now.get("lock") or "")
    current = {"locked": 1, "unlocking": 1, "jammed": 2}.get(state, 0) if state else None
    target = str(values.wanted.get("lock") or state)
    return {"LockCurrentState": current, "LockTargetState": int(target in {"locked", "locking"}) if target else None}


def _write_lock(written: Written, _: PartValues) -> _Settings:
    return {"lock": "locked" if written["LockTargetState"] else "unlocked"} if "LockTargetState" in written else {}


def _setpoints(capabilities: Capabilities) -> list[str]:
    return [name for name in _SETPOINTS if name in capabilities]


def _modes(capabilities: Capabilities) -> dict[str, int]:
    """Return the modes that HomeKit knows; without any, the one of its setpoint."""
    mode = capabilities.get("thermostat_mode")
    known = {word: _MODES[word] for word in mode.options if word in _MODES} if mode and mode.settable else {}
    return known or ({"heat": _HEAT} if "heating_setpoint" in capabilities else {"cool": _COOL})


def _setpoint(mode: int | None, values: PartValues) -> str:
    """Return the name of the setpoint of a mode."""
    return _setpoints(values.capabilities)[-1 if mode == _COOL else 0]


def _mode(values: PartValues) -> int | None:
    modes = _modes(values.capabilities)
    if not values.takes("thermostat_mode"):
        return next(iter(modes.values()))
    return modes.get(str(values.wanted.get("thermostat_mode", values.now.get("thermostat_mode"))))


def _read_climate(values: PartValues) -> _Shown:
    mode, temperature, both = _mode(values), values.number("local_temperature"), {**values.now, **values.wanted}
    target = both.get(_setpoint(mode, values))
    action = {"heating": _HEAT, "preheating": _HEAT, "cooling": _COOL}.get(str(values.now.get("thermostat_action")))
    if "thermostat_action" not in values.capabilities and isinstance(target, float) and temperature is not None:
        is_wanted = target > temperature if mode == _HEAT else target < temperature
        action = mode if is_wanted and mode in {_HEAT, _COOL} else _OFF
    found = {
        "CurrentHeatingCoolingState": action or _OFF,
        "TargetHeatingCoolingState": mode,
        "CurrentTemperature": temperature,
        "TargetTemperature": target,
        "TemperatureDisplayUnits": 0,
        "HeatingThresholdTemperature": both.get("heating_setpoint"),
        "CoolingThresholdTemperature": both.get("cooling_setpoint"),
    }
    return {name: value if isinstance(value, int | float) else None for name, value in found.items()}


def _write_climate(written: Written, values: PartValues) -> _Settings:
    """Return the mode, and then the setpoints: some devices take these in their mode only."""
    settings: _Settings = {}
    mode = _mode(values)
    if "TargetHeatingCoolingState" in written:
        mode = int(written["TargetHeatingCoolingState"])
        if values.takes("thermostat_mode"):
            settings["thermostat_mode"] = next(word for word, one in _modes(values.capabilities).items() if one == mode)
    names = {
        "TargetTemperature": _setpoint(mode, values),
        "HeatingThresholdTemperature": "heating_setpoint",
        "CoolingThresholdTemperature": "cooling_setpoint",
    }
    return settings | {names[name]: float(value) for name, value in written.items() if name in names}


def _read_battery(values: PartValues) -> _Shown:
    level, low, charging = values.number("battery"), values.now.get("battery_low"), values.now.get("battery_charging")
    is_low = low if isinstance(low, bool) else level is not None and level <= _LOW_BATTERY
    state = int(charging) if isinstance(charging, bool) else _NOT_CHARGEABLE
    return {"BatteryLevel": level, "StatusLowBattery": int(is_low), "ChargingState": state}


def _kind(
    name: str,
    characteristics: str,
    read: Callable[[PartValues], _Shown],
    write: Callable[[Written, PartValues], _Settings] | None = None,
) -> ServiceKind:
    """Return the kind with *characteristics*, each perhaps with ``:`` and the capabilities that it needs."""
    rows = (text.partition(":") for text in characteristics.split())
    return ServiceKind(name, {row[0]: row[2].replace("+", " ") for row in rows}, read, write)


def _sensor(service: str, characteristic: str, capability: str, convert: Callable[[float], HapValue]) -> ServiceKind:
    def read(values: PartValues) -> _Shown:
        value = values.now.get(capability)
        return {characteristic: convert(value) if isinstance(value, bool | float) else None}

    return _kind(service, characteristic, read)


_BATTERY: Final = _kind("BatteryService", "BatteryLevel:battery StatusLowBattery ChargingState", _read_battery)
SWITCH: Final = _kind("Switch", "On", lambda values: {"On": _is_on(values)}, _write_power)
_SCENE: Final = SWITCH._replace(
    read=lambda _: {"On": False}, write=lambda written, _: {"scene": True} if written.get("On") else {}
)
_OUTLET: Final = _kind(
    "Outlet", "On OutletInUse", lambda values: dict.fromkeys(("On", "OutletInUse"), _is_on(values)), _write_power
)
_LIGHT: Final = _kind(
    "Lightbulb",
    "On Brightness:level ColorTemperature:color_temperature Hue:color Saturation:color",
    _read_light,
    _write_light,
)
_COVER: Final = _kind(
    "WindowCovering",
    "CurrentPosition TargetPosition PositionState HoldPosition:movement CurrentHorizontalTiltAngle:tilt "
    "TargetHorizontalTiltAngle:tilt",
    _read_cover,
    _write_cover,
)
_GARAGE: Final = _kind(
    "GarageDoorOpener", "CurrentDoorState TargetDoorState ObstructionDetected", _read_garage, _write_garage
)
_LOCK: Final = _kind("LockMechanism", "LockCurrentState LockTargetState", _read_lock, _write_lock)
_CLIMATE: Final = _kind(  # the target of the mode auto is a range if there are two setpoints
    "Thermostat",
    "CurrentHeatingCoolingState TargetHeatingCoolingState CurrentTemperature TargetTemperature TemperatureDisplayUnits "
    "HeatingThresholdTemperature:heating_setpoint+cooling_setpoint "
    "CoolingThresholdTemperature:heating_setpoint+cooling_setpoint",
    _read_climate,
    _write_climate,
)
_MOTORS, _SETPOINTS = ("position", "movement"), ("heating_setpoint", "cooling_setpoint")
_KINDS: Final[Mapping[str, tuple[ServiceKind, tuple[str, ...]]]] = {
    "light": (_LIGHT, ("on_off", "level")),
    "switch": (SWITCH, ("on_off",)),
    "plug": (_OUTLET, ("on_off",)),
    "window_covering": (_COVER, _MOTORS),
    "closure": (_GARAGE, _MOTORS),
    "thermostat": (_CLIMATE, _SETPOINTS),
    "room_air_conditioner": (_CLIMATE, _SETPOINTS),
    "door_lock": (_LOCK, ("lock",)),
    "x_scene": (_SCENE, ("scene",)),
}
"""By the type of a part, with the capabilities of which it must have one."""

_SENSORS: Final[Mapping[str, ServiceKind]] = {
    capability: _sensor(service, characteristic, capability, convert)
    for capability, service, characteristic, convert in (
        ("temperature", "TemperatureSensor", "CurrentTemperature", float),
        ("humidity", "HumiditySensor", "CurrentRelativeHumidity", float),
        ("occupancy", "MotionSensor", "MotionDetected", bool),
        ("contact", "ContactSensor", "ContactSensorState", int),
        ("water_leak", "LeakSensor", "LeakDetected", int),
        ("smoke", "SmokeSensor", "SmokeDetected", int),
        ("carbon_monoxide_alarm", "CarbonMonoxideSensor", "CarbonMonoxideDetected", int),
        ("illuminance", "LightSensor", "CurrentAmbientLightLevel", lambda lux: min(max(lux, _LUX[0]), _LUX[1])),
    )
}
"""By capability, of parts of any type."""
