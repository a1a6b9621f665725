"""Devices that a person has to allow by name: who commands them by mistake lets somebody in, floods or burns. Pure.

What may drive them is the owner's to approve.

A switch or plug that drives such a device is known by its name alone, where that has an English word for it, or by the
tag ``always_ask``, which the owner may give to any device.
"""

from __future__ import annotations

from typing import Final

from homebot.devices.device import Device, DevicePart
from homebot.devices.names import OWNER
from homebot.folding import fold, words_of

__all__ = ["ALWAYS_ASK", "APPROVED", "always_asks", "is_approved", "is_declared", "waits_for_approval"]

ALWAYS_ASK = frozenset({"closure", "door_lock", "water_heater", "water_valve", "x_alarm_panel"})
"""Device types of the class: garage doors and gates, locks, boilers, valves, alarm panels."""

APPROVED: Final = "approved"
"""The name of the fact by which the owner states that a device that can hurt may be driven."""

_CAPABILITIES = frozenset({"alarm", "lock", "valve", "water_heater_mode"})
_OVENS = frozenset({"cooker", "cooktop", "hob", "kiln", "oven", "stove"})
_ENDINGS = frozenset({"boiler", "gate", "lock", "valve"})
_RELAYS = frozenset({"plug", "switch", "x_unknown"})
_HARMLESS = frozenset({"light"})
_TAG = fold("always_ask")


def always_asks(device: Device, part: DevicePart) -> bool:
    """Return whether *part* of *device* is of the class.

    So is every other part of a device with such a part, but for lights: a garage door often has a button beside its
    cover, and a lamp.
    """
    is_named = part.part.service_type in _RELAYS and _is_named(device, part)
    if is_named or is_declared(part) or _TAG in map(fold, device.tags):
        return True
    return part.part.service_type not in _HARMLESS and any(map(is_declared, device.parts))


def is_declared(part: DevicePart) -> bool:
    """Return whether the type of *part*, its announced type, or a capability that can be set says so."""
    told = part.part
    if told.service_type in ALWAYS_ASK or not _OVENS.isdisjoint(words_of(told.advertised)):
        return True
    for one in told.capabilities:  # noqa: SIM110 - a generator would cost each announcement more
        if one.name in _CAPABILITIES and one.settable:
            return True
    return False


def is_approved(device: Device) -> bool:
    """Return whether the owner approved *device*; what it announces of itself does not count."""
    return any(one.name == APPROVED and one.convention == OWNER and not one.gateway for one in device.facts)


def waits_for_approval(device: Device) -> bool:
    """Return whether a part of *device* can hurt and the owner has not approved it."""
    for part in device.parts:  # a generator would cost each announcement more
        if always_asks(device, part):
            return not is_approved(device)
    return False


def _is_named(device: Device, part: DevicePart) -> bool:
    """Return whether the name of *part*, a relay, says what it drives: ``Oven``, ``Front gate``, ``Garage door``."""
    for name in (device.name, *device.names, part.part.name):
        words = words_of(name)
        if not _OVENS.isdisjoint(words) or (words and words[-1] in _ENDINGS) or words[-2:] == ("garage", "door"):
            return True
    return False
