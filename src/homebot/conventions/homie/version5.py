"""Devices of Homie 5, each of which says its state and describes itself in one document. Pure.

A device exists once both are known and it is not starting; a new document counts when it is ready again.

Source: Homie convention 5, Device Lifecycle and $description.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceWithdrawn
from homebot.conventions.homie.described import describe
from homebot.conventions.homie.document import Document, is_id, parse_document
from homebot.conventions.homie.state import STATES
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["Version5"]

_MAX_DEVICES = 5000
_MAX_WAITING = 16_000_000


@dataclass(slots=True)
class _Homie5Device:
    """The documents of one device.

    Attributes:
        state: Its state; empty while it is unknown.
        document_hash: Hash of its document; None while there is none.
        waiting: Its document, as it came, while it counts for nothing because of the state.
        is_described: Whether the gateway was told of it.
    """

    state: str = ""
    document_hash: int | None = None
    waiting: bytes = b""
    is_described: bool = False

    @property
    def is_ready(self) -> bool:
        return self.state not in {"", "init"}


class Version5:
    """Knows the devices of version 5.

    There is room for 5,000, and for 16 MB of documents that wait for a state: of more devices, the one that was heard
    first and never described is forgotten; of more documents, the newest are not taken.

    Attributes:
        ignored: Nodes and properties that were illegal, so far.
    """

    def __init__(self) -> None:
        self.ignored = 0
        self._devices: BoundedDict[_Homie5Device] = BoundedDict(_MAX_DEVICES, self._release)
        self._waiting = 0
        self._refused = 0

    @property
    def dropped(self) -> int:
        """Number of devices or documents that were forgotten or not taken for want of room."""
        return self._devices.dropped + self._refused

    def take(self, domain: str, device_id: str, attribute: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        """Take an attribute of a device.

        Raises:
            WireError: It is illegal.
        """
        if not is_id(device_id):
            raise WireError(f"{shown(device_id)} is no id of a device")
        name = f"{domain}/5/{device_id}"
        if not payload:
            return self._removed(name, attribute)
        device = self._devices.get(name)
        if device is None:
            device = _Homie5Device()
            if not self._devices.add(name, device):
                return ()
        take_attribute = self._take_state if attribute == "$state" else self._take_document
        document = take_attribute(device, domain, device_id, payload)
        return () if document is None else self._describe(device, name, domain, document)

    def _take_state(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> Document | None:
        """Return the document that waited for this state."""
        state = payload.decode(errors="replace") if len(payload) <= len("disconnected") else ""
        if state not in STATES:
            raise WireError(f"$state is {shown(payload)}")
        device.state = state
        if not device.waiting or not device.is_ready:
            return None
        document = parse_document(domain, device_id, device.waiting)
        self._release(device)
        return document

    def _take_document(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> Document | None:
        """Return the document if it is another one and need not wait; what is illegal in it is told now anyway."""
        document_hash = hash(payload)
        if device.document_hash == document_hash:
            return None
        document = parse_document(domain, device_id, payload)
        self._release(device)
        device.document_hash = document_hash
        if device.is_ready:
            return document
        self._keep(device, payload)
        return None

    def _keep(self, device: _Homie5Device, payload: bytes) -> None:
        if self._waiting + len(payload) > _MAX_WAITING:
            device.document_hash = None
            self._refused += 1
            return
        device.waiting = payload
        self._waiting += len(payload)

    def _release(self, device: _Homie5Device) -> None:
        self._waiting -= len(device.waiting)
        device.waiting = b""

    def _describe(
        self, device: _Homie5Device, name: str, domain: str, document: Document
    ) -> tuple[AnnouncementEvent, ...]:
        self.ignored += document.ignored
        described = describe(document.device, domain, is_alive=bool(STATES[device.state]))
        if described is None:
            was_described, device.is_described = device.is_described, False
            return (DeviceWithdrawn(name, "it offers nothing any more"),) if was_described else ()
        self._devices.keep(name)
        device.is_described = True
        return (described,)

    def _removed(self, name: str, attribute: str) -> tuple[AnnouncementEvent, ...]:
        device = self._devices.get(name)
        if device is None:
            return ()
        if attribute == "$state":
            self._release(device)
            self._devices.remove(name)
            return (DeviceWithdrawn(name, "its state was removed", is_final=True),) if device.is_described else ()
        self._release(device)
        device.document_hash = None
        was_described, device.is_described = device.is_described, False
        return (DeviceWithdrawn(name, "its description was removed"),) if was_described else ()
