"""Values of devices as text for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias, cast

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.names import is_text_address

if TYPE_CHECKING:
    from homebot.devices import Device, DevicePart
    from homebot.devices.part import Capability
    from homebot.devices.value import Value

__all__ = ["is_topic", "life", "main_parts", "plain_value", "span", "state_text", "type_text", "types", "value_text"]

PlainValue: TypeAlias = "bool | float | str | list[float] | tuple[float, ...] | None"

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
    "muted": ("not muted", "muted"),
    "state": ("no", "yes"),
}
_MOST = 4


def state_text(device: Device) -> str:
    """Return the last known state in short form; ``unknown`` if there is none, empty if the device never reports."""
    values = {(one.part, one.capability): plain_value(one.value) for one in device.states}
    shown, reports_nothing = [], True
    for part in main_parts(device):
        for capability in part.part.capabilities:
            reports_nothing = reports_nothing and (not capability.readable or capability.name in EVENTS)
            value = values.get((part.id, capability.name))
            if value is not None:
                shown.append(value_text(capability.name, value, capability.unit))
    if not shown:
        return "" if reports_nothing else "unknown"
    return ", ".join(shown[:_MOST]) + (", …" if len(shown) > _MOST else "")


def life(device: Device) -> str:
    """Return the availability of a device, for tables and for its own page."""
    freshness = device.freshness
    if device.reachable.state == "no":
        return "unreachable" if freshness == "fresh" else f"{freshness}, unreachable"
    return f"{freshness}, partly unreachable" if device.offline_parts else freshness


def types(device: Device) -> str:
    """Return the distinct types that the device offers; for a device that sends plain text, its own word."""
    if device.parts and device.service_type not in DEVICE_TYPES:
        return device.service_type
    found = dict.fromkeys(type_text(one.part.service_type) for one in main_parts(device))
    return ", ".join(found) or device.service_type


def type_text(name: str) -> str:
    """Return a type for people, without the prefix of types that are not in Matter."""
    return name.removeprefix("x_")


def main_parts(device: Device) -> Sequence[DevicePart]:
    """Return the main parts of the device; settings and diagnostics if there is nothing else."""
    return [one for one in device.parts if not one.part.category] or device.parts


def value_text(capability: str, value: PlainValue, unit: str = "") -> str:
    """Return a value with *unit*, by default that of the vocabulary: ``on``, ``40 %``, ``no smoke``."""
    match value:
        case None:
            return "unknown"
        case bool():
            words = capability.replace("_", " ")
            no, yes = _FLAGS.get(capability, (f"no {words}", words))
            return yes if value else no
        case str():
            return value
        case list() | tuple():
            return " ".join(_number(one) for one in value)
        case _:
            return f"{_number(value)} {unit or CAPABILITIES.get(capability, OWN).unit}".rstrip()


def span(capability: Capability) -> str:
    """Return its possible values, in words; empty if unknown."""
    known = CAPABILITIES.get(capability.name, OWN)
    if capability.options:
        return ", ".join(capability.options)
    if bounds := capability.bounds or known.bounds:
        unit = capability.unit or known.unit
        steps = f" in steps of {_number(capability.grid[1])}" if capability.grid else ""
        return f"{_number(bounds[0])} to {_number(bounds[-1])} {unit}".rstrip() + steps
    return ""


def plain_value(value: Value) -> PlainValue:
    """Return *value* of a message or of its JSON form, where it is plain; None if unknown."""
    plain = value.plain() if hasattr(value, "plain") else value
    return cast("PlainValue", list(plain) if isinstance(plain, tuple) else plain)


def is_topic(address: str) -> bool:
    """Return whether *address* is meaningful to people, unlike the text address of a part."""
    return bool(address) and not is_text_address(address)


def _number(value: float) -> str:
    return f"{round(value, 2):.15g}"
