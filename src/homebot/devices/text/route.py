"""Address for text commands to a device. Pure."""

from __future__ import annotations

from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.names import is_text_address, text_address
from homebot.devices.text.encode import decode_command
from homebot.errors import RefusedError

__all__ = ["command_address", "others_at"]


def command_address(device: Device, endpoint: Endpoint, said: str) -> str:
    """Return the address at which *endpoint* of *device* is told the word *said*.

    It is the endpoint's own, unless that is one of several ways to a part, of which another one of the same gateway is
    the best that takes what the word means.
    """
    address = endpoint.command_address
    part = _part(device, endpoint) if is_text_address(address) else None
    if part is None or len(part.routes) == 1:
        return address
    try:
        capability, _ = decode_command(said, part.part)
    except RefusedError:
        return address  # its gateway says what it takes
    for route in part.routes:
        if route.gateway == endpoint.gateway and route.can(capability):
            return text_address(route.key, route.part)
    return address


def others_at(device: Device, address: str, said: str) -> tuple[str, ...]:
    """Return the names of the parts that would have taken *said* too, told to the part at *address*: the other gangs.

    They are of the same type as that part, and neither settings nor diagnoses.
    """
    told = _part_at(device, address) if is_text_address(address) else None
    if told is None:
        return ()
    return tuple(
        one.part.name or one.id
        for one in device.parts
        if one is not told
        and one.part.service_type == told.part.service_type
        and one.part.category == told.part.category
        and _takes(one, said)
    )


def _takes(part: DevicePart, said: str) -> bool:
    try:
        decode_command(said, part.part)
    except RefusedError:
        return False
    return True


def _part_at(device: Device, address: str) -> DevicePart | None:
    for part in device.parts:
        if any(text_address(route.key, route.part) == address for route in part.routes):
            return part
    return None


def _part(device: Device, endpoint: Endpoint) -> DevicePart | None:
    for part in device.parts:
        for route in part.routes:
            is_there = route.gateway == endpoint.gateway
            if is_there and text_address(route.key, route.part) == endpoint.command_address:
                return part
    return None
