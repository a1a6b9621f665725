"""Parts of a device by the addresses of its texts. Pure."""

from __future__ import annotations

from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import is_text_address, read_text_address, text_address
from homebot.devices.text.commands import decode_command
from homebot.errors import RefusedError

__all__ = ["command_address", "others_at", "part_at", "sending_part"]


def command_address(device: Device, endpoint: Endpoint, text: str) -> str:
    """Return the address to which *text* is sent for *endpoint* of *device*.

    It is the endpoint's own, unless another of several routes to the part, of the same gateway, is the best that takes
    the command.
    """
    address = endpoint.command_address
    part = _part_at(device, address, endpoint.gateway) if is_text_address(address) else None
    if part is None or len(part.routes) == 1:
        return address
    try:
        capability, _ = decode_command(text, part.part)
    except RefusedError:
        return address  # the error of its gateway names the texts that it takes
    for route in part.routes:
        if route.gateway == endpoint.gateway and route.can(capability):
            return text_address(route.key, route.part)
    return address


def others_at(device: Device, address: str, text: str) -> tuple[str, ...]:
    """Return the names of the parts that also take *text*, which goes to the part at *address*: the other gangs.

    They are of the same type and category as that part.
    """
    target = _part_at(device, address) if is_text_address(address) else None
    if target is None:
        return ()
    return tuple(
        one.part.name or one.id
        for one in device.parts
        if one is not target
        and one.part.service_type == target.part.service_type
        and one.part.category == target.part.category
        and _takes(one, text)
    )


def part_at(device: Device, gateway: str, address: str) -> DevicePart | None:
    """Return the part of *device* that takes texts at *address* of *gateway*; None if that is not known.

    Of several routes to it only those that lead there are left, if any is known to.
    """
    is_text = is_text_address(address)
    keys = {one.key for one in device.endpoints if (one.gateway, one.command_address) == (gateway, address)}
    for part in device.parts:
        routes = [
            one
            for one in part.routes
            if (text_address(one.key, one.part) == address if is_text else one.gateway == gateway and one.key in keys)
        ]
        if routes or address in part.part.writes:
            is_some = 0 < len(routes) < len(part.routes)
            return part.model_copy(update={"routes": tuple(routes)}) if is_some else part
    return None


def sending_part(device: Device, message: RawMessage) -> DevicePart | None:
    """Return the part of *device* that sent *message*; None if that is not known."""
    place = read_text_address(message.address)
    for part in device.parts:
        for route in part.routes:
            is_it = route.key == message.key if place is None else (route.key, route.part) == place
            if is_it and route.gateway == message.gateway:
                return part
    return None


def _takes(part: DevicePart, text: str) -> bool:
    try:
        decode_command(text, part.part)
    except RefusedError:
        return False
    return True


def _part_at(device: Device, address: str, gateway: str = "") -> DevicePart | None:
    """Return the first part with a route, of *gateway* if one is given, to *address*."""
    for part in device.parts:
        for route in part.routes:
            if text_address(route.key, route.part) == address and gateway in {"", route.gateway}:
                return part
    return None
