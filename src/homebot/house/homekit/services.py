"""The services of simulated HomeKit accessories. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 and 9.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from homebot.house.dialect import DeviceState
from homebot.house.dialects.wire import lamp_order
from homebot.house.simulated_device import number_text

__all__ = ["SERVICES", "orders_of", "values_of"]

SERVICES: Final[Mapping[str, tuple[str, ...]]] = {
    "lamp": ("Lightbulb", "Brightness", "ColorTemperature"),
    "window": ("Window", "HoldPosition"),
    "cover": ("WindowCovering", "HoldPosition"),
    "lock": ("LockMechanism",),
    "contact": ("ContactSensor",),
    "motion": ("MotionSensor",),
    "lux": ("LightSensor",),
    "thermostat": ("Thermostat",),
}
"""By kind: the service, and its optional characteristics."""

_MIREDS: Final = 1e6


def values_of(kind: str, state: DeviceState) -> Mapping[str, object]:
    """Return the values of the characteristics that say how a device of this *kind* is."""
    return _VALUES[kind](state)


def orders_of(values: Mapping[str, float]) -> tuple[str, ...]:
    """Return the orders that written characteristics give a device."""
    found: list[str] = []
    if values.keys() & {"On", "Brightness", "ColorTemperature"}:
        brightness, mireds = values.get("Brightness"), values.get("ColorTemperature")
        found += lamp_order(
            is_on=bool(values["On"]) if "On" in values else None,
            brightness=None if brightness is None else brightness / 100,
            kelvin=None if mireds is None else _MIREDS / mireds,
        )
    if "TargetPosition" in values:
        found.append(number_text(values["TargetPosition"] / 100))
    if values.get("HoldPosition"):
        found.append("stop")
    if "LockTargetState" in values:
        found.append("lock" if values["LockTargetState"] else "unlock")
    if "TargetTemperature" in values:
        found.append(number_text(values["TargetTemperature"]))
    return tuple(found)


def _lamp(lamp: DeviceState) -> Mapping[str, object]:
    mireds = min(max(round(_MIREDS / lamp.kelvin), 140), 500)
    return {"On": lamp.is_on, "Brightness": max(1, round(lamp.brightness * 100)), "ColorTemperature": mireds}


def _motor(motor: DeviceState) -> Mapping[str, object]:
    return {"CurrentPosition": round(motor.position * 100), "PositionState": {1: 1, -1: 0}.get(motor.way, 2)}


def _lock(lock: DeviceState) -> Mapping[str, object]:
    now = {"locked": 1, "unlocked": 0}.get(lock.text)
    return {"LockCurrentState": 3} if now is None else {"LockCurrentState": now, "LockTargetState": now}


def _thermostat(thermostat: DeviceState) -> Mapping[str, object]:
    return {
        "CurrentTemperature": thermostat.celsius,
        "TargetTemperature": thermostat.target,
        "CurrentHeatingCoolingState": int(thermostat.heats),
        "TargetHeatingCoolingState": 1,
    }


_VALUES: Final[Mapping[str, Callable[[DeviceState], Mapping[str, object]]]] = {
    "lamp": _lamp,
    "window": _motor,
    "cover": _motor,
    "lock": _lock,
    "contact": lambda door: {"ContactSensorState": int(door.text == "open")},
    "motion": lambda room: {"MotionDetected": room.text == "motion"},
    "lux": lambda lux: {"CurrentAmbientLightLevel": max(0.0001, lux.value)},
    "thermostat": _thermostat,
}
