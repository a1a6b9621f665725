"""Devices of Homie 5, each of which reports its state and describes itself in one document. Pure.

A device exists once both are known and it is not starting; a new document becomes effective when it is ready again.

Source: Homie convention 5, Device Lifecycle.
"""

import re
from dataclasses import dataclass

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.payload import parse_object, shown
from homebot.errors import WireError
from homebot.integrations.homie.formats.model import STATES, HomieDevice
from homebot.integrations.homie.formats.node_reader import optional, read_device
from homebot.integrations.homie.formats.registry import RegisteredDevice, Registry

_ID = re.compile(r"[a-z0-9-]{1,100}")
_VERSION = re.compile(r"5\.[0-9]{1,5}")


def parse_document(domain: str, device_id: str, payload: bytes) -> HomieDevice:
    """Return the device that its ``$description`` describes.

    Raises:
        WireError: It is no document of Homie 5, or a field of the device itself is illegal.
    """
    fields = parse_object(payload)
    version = fields.get("homie")
    if not isinstance(version, str) or not _VERSION.fullmatch(version):
        raise WireError(f"homie is {shown(version)}, not 5.x")
    optional(fields, "version", int)
    for name in ("children", "extensions"):
        optional(fields, name, list)
    root = optional(fields, "root", str) or ""
    parent = optional(fields, "parent", str) or root
    if not all(_ID.fullmatch(relative) for relative in (root, parent) if relative):
        raise WireError(f"root is {shown(root)} and parent {shown(parent)}, not ids")
    root, parent = root if root != device_id else "", parent if parent != device_id else ""
    return read_device(
        fields,
        device_id,
        f"{domain}/5/{device_id}",
        _ID,
        root=f"{domain}/5/{root}" if root else "",
        facts={"via_device": parent} if parent else {},
    )


_MAX_DEVICES = 5000
_MAX_WAITING = 16_000_000


@dataclass(slots=True)
class _Homie5Device(RegisteredDevice):
    """State and document of one device; *waiting* is a document that the state makes ineffective."""

    state: str = ""
    document_hash: int | None = None
    waiting: bytes = b""

    @property
    def is_ready(self) -> bool:
        return self.state not in {"", "init"}


class Version5(Registry[_Homie5Device]):
    """Registry of the devices of version 5.

    Of more than 5,000 devices the oldest undescribed one is dropped; of more than 16 MB of waiting documents the
    newest.
    """

    def __init__(self) -> None:
        super().__init__(_MAX_DEVICES, _MAX_WAITING)

    def read_attribute(
        self, domain: str, device_id: str, attribute: str, payload: bytes
    ) -> tuple[AnnouncementEvent, ...]:
        """Read an attribute of a device.

        Raises:
            WireError: It is illegal.
        """
        if not _ID.fullmatch(device_id):
            raise WireError(f"{shown(device_id)} is not a valid device id")
        name = f"{domain}/5/{device_id}"
        if not payload:
            device = self.devices.get(name)
            if device is None:
                return ()
            self._store_waiting(device, b"")
            if attribute == "$state":
                self.devices.remove(name)
                return self.withdraw(device, name, "its state was removed", is_final=True)
            device.document_hash = None
            return self.withdraw(device, name, "its description was removed")
        device = self.devices.find(name, _Homie5Device)
        if device is None:
            return ()
        read = self._on_state if attribute == "$state" else self._on_document
        document = read(device, domain, device_id, payload)
        if document is None:
            return ()
        return self.announce(device, document, domain, device.state)

    def _on_state(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> HomieDevice | None:
        """Return the document that waited for this state."""
        state = payload.decode(errors="replace") if len(payload) <= len("disconnected") else ""
        if state not in STATES:
            raise WireError(f"$state is {shown(payload)}, not one of {', '.join(STATES)}")
        device.state = state
        if not device.waiting or not device.is_ready:
            return None
        document = parse_document(domain, device_id, device.waiting)
        self._store_waiting(device, b"")
        return document

    def _on_document(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> HomieDevice | None:
        """Return a changed document that is effective now; invalid fields are reported in any case."""
        document_hash = hash(payload)
        if device.document_hash == document_hash:
            return None
        document = parse_document(domain, device_id, payload)
        is_kept = self._store_waiting(device, b"" if device.is_ready else payload)
        device.document_hash = document_hash if is_kept else None
        return document if device.is_ready else None

    def _store_waiting(self, device: _Homie5Device, waiting: bytes) -> bool:
        """Keep a document that waits, or none; return False if there is too little memory."""
        is_kept = self.reserve(device, len(waiting))
        if not is_kept:
            self.reserve(device, 0)
        device.waiting = waiting if is_kept else b""
        return is_kept
