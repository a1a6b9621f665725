"""Look-up of devices in the directory: by id, by query, and by the address of raw commands."""

import math
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from typing import Final, TypeAlias, final

from homebot.devices import FIND_DEVICES, Device, DevicePart, FindDevices
from homebot.devices.device import is_commanded
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import Query
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node

_READ_AGAIN_AFTER: Final = 1.0
"""Seconds after which an unknown address causes all devices to be read again."""

_Address: TypeAlias = tuple[str, str]


@final
class DeviceLookup:
    """Client of the directory; a look-up raises `ServiceError` if the directory does not answer."""

    def __init__(self, node: Node) -> None:
        self._clock = node.graph.clock
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._by_address: dict[_Address, str] = {}
        self._read_at = -math.inf

    async def device(self, device_id: str) -> Device | None:
        """Return a device by its id; None if there is none."""
        devices = (await self._find.call(_request_for(device_id))).devices
        return devices[0] if devices else None

    async def known(self, device_id: str) -> Device | None:
        """Return a device by its id; None if there is none, or no answer."""
        with suppress(ServiceError):
            return await self.device(device_id)
        return None

    async def find_called(self, name: str, device_id: str = "") -> tuple[Device, ...]:
        """Return the devices that *name* calls; see :func:`homebot.devices.device_names.devices_called`."""
        from homebot.devices.device_names import devices_called, name_query  # noqa: PLC0415 - for names alone

        return devices_called(name, await self.devices(name_query(name, device_id)), device_id)

    async def devices(self, query: Query | None = None) -> tuple[Device, ...]:
        """Return the devices that fit *query*, or all."""
        request = FindDevicesRequest() if query is None else FindDevicesRequest(query=query_terms(query))
        return (await self._find.call(request)).devices

    async def all_known(self, query: Query | None = None) -> tuple[Device, ...]:
        """Return the devices that fit *query*, or all; none without an answer."""
        with suppress(ServiceError):
            return await self.devices(query)
        return ()

    async def members(self, device: Device, part: DevicePart) -> list[tuple[Device, DevicePart]]:
        """Return the parts that a command to *part* sets too, also by groups in it; none without an answer."""
        known = [
            (known_device, other)
            for known_device in await self.all_known()
            for other in known_device.parts
            if is_commanded(other.part)
        ]
        members, groups = {(device.id, part.id): (device, part)}, [part]
        for group in groups:  # which grows
            wanted, gateways = frozenset(group.part.members), {route.gateway for route in group.routes}
            for known_device, other in known:
                place = known_device.id, other.id
                if place not in members and not wanted.isdisjoint(references(known_device, other, gateways)):
                    members[place] = known_device, other
                    groups += [other] if other.part.members else []
        return list(members.values())[1:]

    async def device_at(self, gateway: str, address: str) -> str:
        """Return the id of the device that takes commands at *address*; empty if there is none, or no answer.

        All devices are read for an unknown address, at most once a second.
        """
        now, place = self._clock.monotonic(), (gateway, address)
        known = self._by_address.get(place, "")
        try:
            device = await self.device(known) if known else None
            if device is not None and place in _addresses(device):  # it was not merged, split or replaced
                return known
            if now - self._read_at >= _READ_AGAIN_AFTER:
                self._read_at = now
                devices = await self.devices()
                self._by_address = {place: device.id for device in reversed(devices) for place in _addresses(device)}
        except ServiceError:
            return ""
        return self._by_address.get(place, "")


@lru_cache(maxsize=1024)
def _request_for(device_id: str) -> FindDevicesRequest:
    return FindDevicesRequest(ids=(device_id,), service_type="", query=())


def references(device: Device, part: DevicePart, gateways: Collection[str]) -> Iterator[str]:
    """Yield what a group in one of *gateways* may call a part; see :attr:`homebot.devices.part.Part.members`."""
    yield from device.identifiers
    for route in part.routes:
        yield from (f"{identifier}#{route.part}" for identifier in device.identifiers)
        if route.gateway in gateways:
            yield f"#{route.part}"


def _addresses(device: Device) -> Iterable[_Address]:
    for endpoint in device.endpoints:
        if endpoint.command_address:
            yield endpoint.gateway, endpoint.command_address
    for part in device.parts:
        for route in part.routes:
            for address in part.part.writes:
                yield route.gateway, address
