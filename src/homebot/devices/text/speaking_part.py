"""Part of a device that sent a raw message. Pure."""

from __future__ import annotations

from homebot.devices.device import Device, DevicePart
from homebot.devices.names import read_text_address
from homebot.devices.raw import RawMessage

__all__ = ["speaking_part"]


def speaking_part(device: Device, message: RawMessage) -> DevicePart | None:
    """Return the part of *device* that said *message*; None where that is not known."""
    words = read_text_address(message.address)
    for part in device.parts:
        for route in part.routes:
            is_it = route.key == message.key if words is None else (route.key, route.part) == words
            if is_it and route.gateway == message.gateway:
                return part
    return None
