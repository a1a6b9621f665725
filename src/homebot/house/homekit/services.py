"""The services of simulated HomeKit accessories. Pure.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 and 9.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from homebot.house.dialect import DeviceState
from homebot.house.dialects.wire import device_orders, mired_kelvin, scaled

__all__ = ["SERVICES", "VALUES", "orders_of"]

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
_LOCKS: Final = {0: "unlock", 1: "lock"}


def orders_of(kind: str, values: Mapping[str, float]) -> tuple[str, ...]:
    """Return the orders that written characteristics give a device of this *kind*."""
    return device_orders(
        kind,
        is_on=bool(values["On"]) if "On" in values else None,
        brightness=scaled(values.get("Brightness"), 100),
        kelvin=mired_kelvin(values.get("ColorTemperature")),
        position=scaled(values.get("TargetPosition"), 100),
        action="stop" if values.get("HoldPosition") else _LOCKS.get(int(values.get("LockTargetState", -1)), ""),
        target=values.get("TargetTemperature"),
    )


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


VALUES: Final[Mapping[str, Callable[[DeviceState], Mapping[str, object]]]] = {
    "lamp": _lamp,
    "window": _motor,
    "cover": _motor,
    "lock": _lock,
    "contact": lambda door: {"ContactSensorState": int(door.text == "open")},
    "motion": lambda room: {"MotionDetected": room.text == "motion"},
    "lux": lambda lux: {"CurrentAmbientLightLevel": max(0.0001, lux.value)},
    "thermostat": _thermostat,
}
"""By kind: the values of the characteristics that say how a device is."""
