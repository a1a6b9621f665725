"""Approval: the owner's statement that a device that can hurt may be driven. Pure."""

from __future__ import annotations

from typing import Final

from homebot.devices.always_ask import always_asks
from homebot.devices.device import Device
from homebot.devices.names import OWNER

__all__ = ["APPROVED", "is_approved", "waits_for_approval"]

APPROVED: Final = "approved"
"""The name of the fact."""


def is_approved(device: Device) -> bool:
    """Return whether the owner approved *device*; what it announces of itself does not count."""
    return any(one.name == APPROVED and one.convention == OWNER and not one.gateway for one in device.facts)


def waits_for_approval(device: Device) -> bool:
    """Return whether a part of *device* can hurt and the owner has not approved it."""
    for part in device.parts:  # a generator would cost each announcement more
        if always_asks(device, part):
            return not is_approved(device)
    return False
