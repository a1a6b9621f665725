"""The attributes and commands of simulated Matter devices. Pure.

Source: Matter 1.4 Application Clusters and Device Library.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.dialects.wire import hardware_address, lamp_order
from homebot.house.simulated_device import number_text

__all__ = ["DEVICE_TYPES", "Attributes", "attributes_of", "command_orders", "state_attributes", "write_orders"]

Attributes: TypeAlias = dict[str, object]
"""Values by path: ``1/6/0``."""

DEVICE_TYPES: Final[Mapping[str, int]] = MappingProxyType(
    {
        "lamp": 0x010C,
        "window": 0x0202,
        "cover": 0x0202,
        "lock": 0x000A,
        "contact": 0x0015,
        "motion": 0x0107,
        "lux": 0x0106,
        "power_meter": 0x0510,
        "thermostat": 0x0301,
    }
)
"""By kind."""

_LEVELS: Final = 254
_MIREDS: Final = 1e6


def attributes_of(device: SimulatedDeviceInfo, state: DeviceState) -> Attributes:
    """Return all attributes of the node that *device* is."""
    return {
        "0/29/0": [{"0": 0x0016, "1": 1}],
        "0/29/3": [1],
        "0/40/1": "homebot",
        "0/40/3": f"SIM-{device.kind}",
        "0/40/5": device.device_id,
        "0/40/10": "1.0",
        "0/40/15": hardware_address(device, 16),
        "1/3/0": 0,
        "1/3/1": 2,
        "1/29/0": [{"0": DEVICE_TYPES[device.kind], "1": 1}],
        "1/29/3": [],
        **_FIXED.get(device.kind, {}),
        **state_attributes(device, state),
    }


def state_attributes(device: SimulatedDeviceInfo, state: DeviceState) -> Attributes:
    """Return the attributes that say how *device* is."""
    return _STATES[device.kind](state)


def command_orders(kind: str, cluster: int, command: str, payload: Mapping[str, object]) -> tuple[str, ...] | None:
    """Return what a command tells a device to do, as text; None for a command that it does not have."""
    if kind == "lamp":
        return _lamp_orders(cluster, command, payload)
    if kind in {"window", "cover"} and cluster == 258:
        if command == "GoToLiftPercentage":
            closed = _number(payload.get("liftPercent100thsValue"))
            return None if closed is None else (number_text(1 - closed / 10_000),)
        found = {"UpOrOpen": "open", "DownOrClose": "close", "StopMotion": "stop"}.get(command)
        return None if found is None else (found,)
    if kind == "lock" and cluster == 257:
        found = {"LockDoor": "lock", "UnlockDoor": "unlock"}.get(command)
        return None if found is None else (found,)
    return None


def write_orders(kind: str, path: str, value: object) -> tuple[str, ...] | None:
    """Return what a new value of an attribute tells a device to do, as text; None where it cannot be written."""
    if kind == "thermostat" and path == "1/513/18":
        hundredths = _number(value)
        return None if hundredths is None else (number_text(hundredths / 100),)
    if kind == "thermostat" and path == "1/513/28":
        return ()
    return None


def _lamp_orders(cluster: int, command: str, payload: Mapping[str, object]) -> tuple[str, ...] | None:
    if cluster == 6 and command in {"On", "Off"}:
        return (command.lower(),)
    if cluster == 8 and command == "MoveToLevelWithOnOff":
        level = _number(payload.get("level"))
        if level is None:
            return None
        return lamp_order(brightness=level / _LEVELS) if level else ("off",)
    if cluster == 768 and command == "MoveToColorTemperature":
        mireds = _number(payload.get("colorTemperatureMireds"))
        return lamp_order(kelvin=_MIREDS / mireds) if mireds else None
    return None


def _lamp(lamp: DeviceState) -> Attributes:
    return {
        "1/6/0": lamp.is_on,
        "1/8/0": max(1, round(lamp.brightness * _LEVELS)),
        "1/768/7": round(_MIREDS / lamp.kelvin),
    }


def _motor(motor: DeviceState) -> Attributes:
    way = {1: 0b0101, -1: 0b1010}.get(motor.way, 0)
    return {"1/258/14": round((1 - motor.position) * 10_000), "1/258/10": way}


def _thermostat(thermostat: DeviceState) -> Attributes:
    return {
        "1/513/0": round(thermostat.celsius * 100),
        "1/513/18": round(thermostat.target * 100),
        "1/513/41": 1 if thermostat.heats else 0,
    }


def _lux(lux: DeviceState) -> Attributes:
    return {"1/1024/0": min(round(10_000 * math.log10(lux.value) + 1), 0xFFFE) if lux.value >= 1 else 0}


_FIXED: Final[Mapping[str, Attributes]] = {
    "lamp": {
        "1/6/65532": 1,
        "1/8/2": 1,
        "1/8/3": _LEVELS,
        "1/8/65532": 3,
        "1/768/8": 2,
        "1/768/16385": 2,
        "1/768/16395": 112,
        "1/768/16396": 666,
        "1/768/65532": 16,
    },
    "window": {"1/258/65532": 0b101},
    "cover": {"1/258/65532": 0b101},
    "lock": {"1/257/65532": 0, "1/257/51": False},
    "thermostat": {"1/513/3": 500, "1/513/4": 3000, "1/513/28": 4, "1/513/65532": 1},
}

_STATES: Final[Mapping[str, Callable[[DeviceState], Attributes]]] = MappingProxyType(
    {
        "lamp": _lamp,
        "window": _motor,
        "cover": _motor,
        "lock": lambda lock: {"1/257/0": {"locked": 1, "unlocked": 2}.get(lock.text, 0)},
        "contact": lambda door: {"1/69/0": door.text != "open"},
        "motion": lambda room: {"1/1030/0": 1 if room.text == "motion" else 0},
        "lux": _lux,
        "power_meter": lambda meter: {"1/144/8": round(meter.value * 1000)},
        "thermostat": _thermostat,
    }
)


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None
