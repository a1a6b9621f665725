"""What devices without parts are trusted to understand: the plain words of the thesis. Pure."""

from __future__ import annotations

from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.devices.words import word

__all__ = ["assumed", "phrase"]

_CAPABILITIES = {
    "light": ("on_off", "level", "color_temperature"),
    "plug": ("on_off",),
    "switch": ("on_off",),
    "window_covering": ("movement", "position"),
    "closure": ("movement", "position"),
    "door_lock": ("lock",),
    "thermostat": ("heating_setpoint",),
}

_ORDERS = {
    ("movement", "closed"): "close",
    ("movement", "stopped"): "stop",
    ("lock", "locked"): "lock",
    ("lock", "unlocked"): "unlock",
}
"""Where a device is told another word than it says."""


def assumed(service_type: str) -> tuple[Capability, ...]:
    """Return what a device is trusted to take of which only the type is known, and that it takes commands."""
    return tuple(Capability(name=name, readable=False, settable=True) for name in _CAPABILITIES.get(service_type, ()))


def phrase(capability: str, value: PlainValue) -> str:
    """Return the word by which a device is told that *capability* shall be *value*; empty where there is none."""
    if isinstance(value, str) and (capability, value) in _ORDERS:
        return _ORDERS[capability, value]
    return word({capability: value}) or ""
