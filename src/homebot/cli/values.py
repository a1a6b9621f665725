"""Values of devices as text for people."""

from __future__ import annotations

from collections.abc import Sequence

from homebot.devices.capabilities import CAPABILITIES, EVENTS
from homebot.devices.device import Device, DevicePart
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["life", "main_parts", "span", "state_text", "types", "value_text"]

_FLAGS = {
    "on_off": ("off", "on"),
    "contact": ("closed", "open"),
    "occupancy": ("clear", "occupied"),
    "connectivity": ("disconnected", "connected"),
    "unlocked": ("locked", "unlocked"),
    "plugged_in": ("unplugged", "plugged in"),
    "battery_low": ("battery good", "battery low"),
    "battery_charging": ("not charging", "charging"),
    "update_available": ("up to date", "update available"),
    "running": ("idle", "running"),
    "moving": ("still", "moving"),
    "safety": ("safe", "unsafe"),
    "water_leak": ("dry", "wet"),
    "state": ("no", "yes"),
}
_MOST = 4


def state_text(device: Device) -> str:
    """Return in short what the parts last told; ``unknown`` where they told nothing, empty where they never do."""
    values = {(one.part, one.capability): one.value.plain() for one in device.states}
    shown, reports_nothing = [], True
    for part in main_parts(device):
        for capability in part.part.capabilities:
            reports_nothing = reports_nothing and (not capability.readable or capability.name in EVENTS)
            value = values.get((part.id, capability.name))
            if value is not None:
                shown.append(value_text(capability, value))
    if not shown:
        return "" if reports_nothing else "unknown"
    return ", ".join(shown[:_MOST]) + (", …" if len(shown) > _MOST else "")


def life(device: Device) -> str:
    """Return in words how a device is: the same for a table and for a page of its own."""
    if device.reachable.state == "no":
        return f"{device.freshness}, unreachable"
    return f"{device.freshness}, partly unreachable" if device.offline_parts else device.freshness


def types(device: Device) -> str:
    """Return what the device offers, each type once; for one that speaks plain words, its own word for that."""
    if device.parts and device.service_type not in DEVICE_TYPES:
        return device.service_type
    found = dict.fromkeys(one.part.service_type for one in main_parts(device))
    return ", ".join(found) or device.service_type


def main_parts(device: Device) -> Sequence[DevicePart]:
    """Return the parts that the device is there for; settings and self-observations where there is nothing else."""
    return [one for one in device.parts if not one.part.category] or device.parts


def value_text(capability: Capability, value: PlainValue) -> str:
    """Return a value with its unit, so that it can stand alone: ``on``, ``40 %``, ``no smoke``."""
    match value:
        case None:
            return "unknown"
        case bool():
            no, yes = _FLAGS.get(capability.name, (f"no {_spaced(capability)}", _spaced(capability)))
            return yes if value else no
        case str():
            return value
        case tuple():
            return " ".join(_number(one) for one in value)
        case _:
            return f"{_number(value)} {_unit(capability)}".rstrip()


def span(capability: Capability) -> str:
    """Return which values it may have, in words; empty where nothing is known of that."""
    known = CAPABILITIES.get(capability.name)
    if capability.options:
        return ", ".join(capability.options)
    bounds = capability.bounds or (known.bounds if known else ())
    if bounds:
        return f"{_number(bounds[0])} to {_number(bounds[-1])} {_unit(capability)}".rstrip()
    return ""


def _unit(capability: Capability) -> str:
    known = CAPABILITIES.get(capability.name)
    return capability.unit or (known.unit if known else "")


def _spaced(capability: Capability) -> str:
    return capability.name.replace("_", " ")


def _number(value: float) -> str:
    return f"{round(value, 2):.15g}"
