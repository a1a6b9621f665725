"""The devices behind the addresses that raw commands go to."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, TypeAlias, final

from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node

__all__ = ["CommandAddresses"]

_READ_AFTER: Final = 1.0
"""Seconds after which the devices are read again for an address that none of them had."""

_Address: TypeAlias = tuple[str, str]


@final
class CommandAddresses:
    """The device of each address, as the directory had them when they were last read.

    They are read for an address that is unknown, at most once a second, however many there are.

    Args:
        node: The node that asks the directory.
    """

    def __init__(self, node: Node) -> None:
        self._clock = node.graph.clock
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._devices: dict[_Address, str] = {}
        self._read_at = -math.inf

    async def device_at(self, gateway: str, address: str) -> str:
        """Return the id of the device that takes commands at *address* of *gateway*; empty where none is known to."""
        if (gateway, address) not in self._devices and self._clock.monotonic() - self._read_at >= _READ_AFTER:
            self._read_at = self._clock.monotonic()
            try:
                found = (await self._find.call(FindDevicesRequest())).devices
            except ServiceError:
                return ""
            self._devices = {place: one.id for one in reversed(found) for place in _addresses(one)}
        return self._devices.get((gateway, address), "")


def _addresses(device: Device) -> Iterable[_Address]:
    for endpoint in device.endpoints:
        if endpoint.command_address:
            yield endpoint.gateway, endpoint.command_address
    for part in device.parts:
        for route in part.routes:
            for address in part.part.writes:
                yield route.gateway, address
