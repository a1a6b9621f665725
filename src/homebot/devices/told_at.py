"""Where a device is told a word. Pure."""

from __future__ import annotations

from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.words import meaning, words_address
from homebot.errors import RefusedError

__all__ = ["told_at"]


def told_at(device: Device, endpoint: Endpoint, said: str) -> str:
    """Return the address at which *endpoint* of *device* is told the word *said*.

    It is the endpoint's own, unless that is one of several ways to a part, of which another one of the same gateway is
    the best that takes what the word means.
    """
    address = endpoint.command_address
    part = _part(device, endpoint)
    if part is None or len(part.routes) == 1:
        return address
    try:
        capability, _ = meaning(said, part.part)
    except RefusedError:
        return address  # its gateway says what it takes
    for route in part.routes:
        if route.gateway == endpoint.gateway and route.can(capability):
            return words_address(route.key, route.part)
    return address


def _part(device: Device, endpoint: Endpoint) -> DevicePart | None:
    for part in device.parts:
        for route in part.routes:
            is_there = route.gateway == endpoint.gateway
            if is_there and words_address(route.key, route.part) == endpoint.command_address:
                return part
    return None
