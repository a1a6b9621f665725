"""Clients of the directory: the device that a tag or a code points to, and the room that a tag assigns to it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, final
from urllib.parse import urlsplit

from homebot.conventions.nfc.pointer import Pointer
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.device_names import is_called
from homebot.devices.identity import identifiers
from homebot.devices.names import TEACH_PLACE
from homebot.devices.places_messages import TeachPlace, TeachPlaceRequest
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.log import LogLimit

TAUGHT: Final = "nfc.place_taught"
NOT_TAUGHT: Final = "nfc.place_not_taught"

_KEPT_FOR: Final = 1.0
"""Seconds for which the list of devices is kept, as many tags may be read at once."""

_MAX_CANDIDATES: Final = 20
_HOSTS: Final = ("host", "ip_address")


@dataclass(frozen=True, slots=True)
class PointedAt:
    """The devices that a pointer fits; a useful tag or code fits exactly one."""

    devices: tuple[Device, ...] = ()

    @property
    def device(self) -> Device | None:
        """The only device; None if there are none or several."""
        return self.devices[0] if len(self.devices) == 1 else None

    @property
    def id(self) -> str:
        """The id of the only device; empty if there are none or several."""
        return self.device.id if self.device is not None else ""

    @property
    def candidates(self) -> tuple[str, ...]:
        """The ids of the devices, of the first 20."""
        return tuple(device.id for device in self.devices[:_MAX_CANDIDATES])


class DeviceFinder:
    """Finds devices by pointers, but never tags that only its own gateway knows."""

    def __init__(self, node: Node) -> None:
        self._gateway = node.name
        self._clock = node.graph.clock
        self._client = node.create_client(FindDevices, FIND_DEVICES)
        self._devices: tuple[Device, ...] = ()
        self._asked_at = float("-inf")

    async def find(self, pointer: Pointer) -> PointedAt:
        """Return the devices that fit the most reliable attribute of *pointer* that any device fits."""
        if not (pointer.text or pointer.id or pointer.words):
            return PointedAt()
        devices = await self._all()
        for fits in _tests(pointer):
            fitting = tuple(device for device in devices if fits(device))
            if fitting:
                return PointedAt(fitting)
        return PointedAt()

    async def _all(self) -> tuple[Device, ...]:
        now = self._clock.monotonic()
        if now - self._asked_at >= _KEPT_FOR:
            try:
                answer = await self._client.call(FindDevicesRequest())
            except ServiceError:  # no directory runs, or it is too busy: nothing is known
                return ()
            self._devices = tuple(device for device in answer.devices if not self._is_own(device))
            self._asked_at = now
        return self._devices

    def _is_own(self, device: Device) -> bool:
        return (
            all(endpoint.gateway == self._gateway for endpoint in device.endpoints) and "x_tag" in device.service_types
        )


@final
class RoomTagger:
    """Assigns rooms to devices that tags point to: a tag at a device knows the room."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._client = node.create_client(TeachPlace, TEACH_PLACE)
        self._limit = LogLimit(node.graph.clock)

    async def assign_room(self, tag: str, device: str, room: str) -> None:
        """Report that the tag *tag* points to *device*, and is in *room*, which is empty if the tag says none."""
        request = TeachPlaceRequest(device=device, gateway=self._node.name, tag=tag, room=room)
        try:
            answer = await self._client.call(request)
        except ServiceError as exc:
            self._log_failure(tag, device, str(exc))
            return
        if answer.success and answer.is_new:
            text = f"the tag {tag} says where {device} is, which is in {answer.room} now"
            self._node.log.info(TAUGHT, message=text, device=device, tag=tag)
        elif not answer.success and room:
            self._log_failure(tag, device, answer.message)

    def _log_failure(self, tag: str, device: str, why: str) -> None:
        held_back = self._limit.allows(NOT_TAUGHT)
        if held_back is not None:
            text = f"the tag {tag} teaches no room of {device}: {why}"
            self._node.log.warning(NOT_TAUGHT, message=text, device=device, tag=tag, held_back=held_back)


def _tests(pointer: Pointer) -> Iterator[Callable[[Device], bool]]:
    """Yield the tests of a device, the most reliable first."""
    if pointer.id:
        yield lambda device: device.id == pointer.id
    if pointer.thing is not None:
        own = frozenset(pointer.thing.identifiers)
        yield lambda device: not own.isdisjoint(device.identifiers)
    yield from (lambda device, code=code: code.fits(_facts(device)) for code in pointer.codes)
    if pointer.address:
        yield lambda device: any(_is_at(pointer.address, endpoint.address) for endpoint in device.endpoints)
    if pointer.urls:
        urls = frozenset(pointer.urls)
        yield lambda device: any(item.value in urls for item in device.metadata)
        yield lambda device: _has_host_of(device, pointer.urls)
    if pointer.words:
        words, declared = frozenset(pointer.words), frozenset(identifiers(pointer.words))
        yield lambda device: device.id in words
        yield lambda device: not declared.isdisjoint(device.identifiers) or not words.isdisjoint(device.identifiers)
        yield lambda device: any(is_called(device, word) for word in words)


def _facts(device: Device) -> dict[str, str]:
    return {item.key.casefold(): item.value for item in device.metadata}


def _is_at(address: str, published: str) -> bool:
    """Return whether *address* is the topic *published*, or a level above it."""
    return published == address or published.startswith(f"{address}/")


def _has_host_of(device: Device, urls: tuple[str, ...]) -> bool:
    hosts = {(urlsplit(url).hostname or "").removesuffix(".") for url in urls} - {""}
    facts = _facts(device)
    own = {facts.get(name, "").casefold().removesuffix(".") for name in _HOSTS}
    return not hosts.isdisjoint(own - {""})
