"""Values of devices as text for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias, cast

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.names import is_text_address

if TYPE_CHECKING:
    from homebot.devices import Device, DevicePart
    from homebot.devices.part import Capability
    from homebot.devices.value import Value

PlainValue: TypeAlias = "bool | float | str | list[float] | tuple[float, ...] | None"

_MAX_SHOWN = 4
_DIGITS, _LARGE = 2, 10
"""Decimal places of a number, and from where on it has only one of them."""


def state_text(device: Device) -> str:
    """Return the last known state in short form; ``unknown`` if there is none, empty if the device never reports."""
    values = {(state.part, state.capability): plain_value(state.value) for state in device.states}
    shown, reports_nothing = [], True
    for part in main_parts(device):
        for capability in part.part.capabilities:
            reports_nothing = reports_nothing and (not capability.readable or capability.name in EVENTS)
            value = values.get((part.id, capability.name))
            if value is not None:
                shown.append(value_text(capability.name, value, capability.unit, step_of(capability)))
    if not shown:
        return "" if reports_nothing else "unknown"
    return ", ".join(shown[:_MAX_SHOWN]) + (", …" if len(shown) > _MAX_SHOWN else "")


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
    names = dict.fromkeys(type_text(part.part.service_type) for part in main_parts(device))
    return ", ".join(names) or device.service_type


def type_text(name: str) -> str:
    """Return a type for people, without the prefix of types that are not in Matter."""
    return name.removeprefix("x_")


def main_parts(device: Device) -> Sequence[DevicePart]:
    """Return the main parts of the device; settings and diagnostics if there is nothing else."""
    return [part for part in device.parts if not part.part.category] or device.parts


def flag_texts(capability: str) -> tuple[str, str]:
    """Return the words for no and yes."""
    words = capability.replace("_", " ")
    return CAPABILITIES.get(capability, OWN).flags or (f"no {words}", words)


def value_text(capability: str, value: PlainValue, unit: str = "", step: float = 0.0) -> str:
    """Return a value with *unit*, by default that of the vocabulary: ``on``, ``40 %``, ``no smoke``.

    Args:
        step: That of the device's numbers; 0 if unknown.
    """
    match value:
        case None:
            return "unknown"
        case bool():
            return flag_texts(capability)[value]
        case str():
            return value
        case list() | tuple():
            return " ".join(_number(number) for number in value)
        case _:
            unit = unit or CAPABILITIES.get(capability, OWN).unit
            return f"{_round(value, unit, step)} {unit}".rstrip()


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


def step_of(capability: Capability) -> float:
    """Return the step between two numbers that it can be set to; 0 if unknown."""
    return capability.grid[1] if capability.grid else 0.0


def plain_value(value: Value) -> PlainValue:
    """Return *value* of a message or of its JSON form, where it is plain; None if unknown."""
    plain = value.plain() if hasattr(value, "plain") else value
    return cast("PlainValue", list(plain) if isinstance(plain, tuple) else plain)


def is_topic(address: str) -> bool:
    """Return whether *address* is meaningful to people, unlike the text address of a part."""
    return bool(address) and not is_text_address(address)


def _round(value: float, unit: str, step: float) -> str:
    """Return *value* as people say it: 40.16 % is 40 %, unless the device has half percents."""
    near, most = abs(value), 1 if unit == "%" else _DIGITS
    usual = int(0 < near < 1) if unit == "%" else 1 if unit == "°C" or near >= _LARGE else _DIGITS
    shown = (
        digits for digits in range(_DIGITS + 1) if step and math.isclose(step * 10**digits, round(step * 10**digits))
    )
    return f"{round(value, min(next(shown, usual), most)):.15g}"


def _number(value: float) -> str:
    return f"{round(value, 2):.15g}"
