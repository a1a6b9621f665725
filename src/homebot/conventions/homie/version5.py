"""Devices of Homie 5, each of which reports its state and describes itself in one document. Pure.

A device exists once both are known and it is not starting; a new document becomes effective when it is ready again.
Unknown fields are ignored; an invalid field invalidates its property, its node or the whole device.

Source: Homie convention 5, Device Lifecycle, Device Attributes ($description), Nodes, Properties.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.homie.model import (
    MAX_PROPERTIES,
    STATES,
    HomieDevice,
    HomieNode,
    HomieProperty,
    make_property,
)
from homebot.conventions.homie.registry import RegisteredDevice, Registry
from homebot.conventions.payload import clean_text, parse_object, shown
from homebot.errors import WireError

__all__ = ["Document", "Version5", "parse_document"]


T = TypeVar("T")

_ID = re.compile(r"[a-z0-9-]{1,100}")
_VERSION = re.compile(r"5\.[0-9]{1,5}")
_LONGEST_TYPE = 200


@dataclass(frozen=True, slots=True)
class Document:
    """A described device, and the number of its invalid nodes and properties."""

    device: HomieDevice
    ignored: int


def _is_id(text: str) -> bool:
    """Return whether *text* is an id: small letters, digits and hyphens."""
    return _ID.fullmatch(text) is not None


def parse_document(domain: str, device_id: str, payload: bytes) -> Document:
    """Return the parsed ``$description`` of a device.

    Raises:
        WireError: It is no document of Homie 5, or a field of the device itself is illegal.
    """
    fields = parse_object(payload)
    version = fields.get("homie")
    if not isinstance(version, str) or not _VERSION.fullmatch(version):
        raise WireError(f"homie is {shown(version)}, not 5.x")
    _optional(fields, "version", int)
    for name in ("children", "extensions"):
        _optional(fields, name, list)
    root, parent = _relatives(fields, device_id)
    topic = f"{domain}/5/{device_id}"
    reader = _DocumentReader(topic)
    nodes = reader.nodes(_optional(fields, "nodes", dict) or {})
    device = HomieDevice(
        id=device_id,
        name=clean_text(_optional(fields, "name", str) or "") or device_id,
        type=(_optional(fields, "type", str) or "")[:_LONGEST_TYPE],
        topic=topic,
        nodes=nodes,
        root=f"{domain}/5/{root}" if root else "",
        facts={"via_device": parent} if parent else {},
    )
    return Document(device, reader.ignored)


def _relatives(fields: Mapping[str, object], device_id: str) -> tuple[str, str]:
    """Return the ids of the root and the parent of a device, each empty for none."""
    root = _optional(fields, "root", str) or ""
    parent = _optional(fields, "parent", str) or root
    if not all(_is_id(relative) for relative in (root, parent) if relative):
        raise WireError(f"root is {shown(root)} and parent {shown(parent)}, not ids")
    return root if root != device_id else "", parent if parent != device_id else ""


class _DocumentReader:
    def __init__(self, topic: str) -> None:
        self.ignored = 0
        self._topic = topic
        self._count = 0

    def nodes(self, fields: Mapping[str, object]) -> tuple[HomieNode, ...]:
        found = []
        for node_id, node in fields.items():
            if self._count >= MAX_PROPERTIES:
                self.ignored += 1
                continue
            try:
                found.append(self._node(node_id, node))
            except WireError:
                self.ignored += 1
        return tuple(found)

    def _node(self, node_id: str, fields: object) -> HomieNode:
        name = _legal_id(node_id)
        if not isinstance(fields, dict):
            raise WireError(f"node {shown(name)} is {shown(fields)}, not an object")
        return HomieNode(
            id=name,
            name=clean_text(_optional(fields, "name", str) or ""),
            type=clean_text(_optional(fields, "type", str) or "", _LONGEST_TYPE),
            properties=self._properties(name, _optional(fields, "properties", dict) or {}),
        )

    def _properties(self, node_id: str, fields: Mapping[str, object]) -> tuple[HomieProperty, ...]:
        found = []
        for prop_id, prop in fields.items():
            try:
                if self._count >= MAX_PROPERTIES:
                    raise WireError(f"more than {MAX_PROPERTIES} properties")  # noqa: TRY301 - as any other flaw
                found.append(self._property(node_id, prop_id, prop))
            except WireError:
                self.ignored += 1
            else:
                self._count += 1
        return tuple(found)

    def _property(self, node_id: str, prop_id: str, fields: object) -> HomieProperty:
        name = _legal_id(prop_id)
        if not isinstance(fields, dict):
            raise WireError(f"property {shown(name)} is {shown(fields)}, not an object")
        return make_property(
            lambda key: _optional(fields, key, str) or "",
            prop_id=name,
            topic=f"{self._topic}/{node_id}/{name}",
            is_settable=_optional(fields, "settable", bool) or False,
            is_retained=_optional(fields, "retained", bool) is not False,
        )


def _optional(fields: Mapping[str, object], name: str, kind: type[T]) -> T | None:
    """Return a field; None if it is missing.

    Raises:
        WireError: It is of another type. A boolean is no number.
    """
    if name not in fields:
        return None
    value = fields[name]
    if isinstance(value, kind) and (kind is bool or not isinstance(value, bool)):
        return value
    raise WireError(f"{name} is {shown(value)}, not a {kind.__name__}")


def _legal_id(value: str) -> str:
    if _is_id(value):
        return value
    raise WireError(f"{shown(value)} is not a valid id")


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
        super().__init__(_MAX_DEVICES)
        self._waiting = 0

    def read_attribute(
        self, domain: str, device_id: str, attribute: str, payload: bytes
    ) -> tuple[AnnouncementEvent, ...]:
        """Read an attribute of a device.

        Raises:
            WireError: It is illegal.
        """
        if not _is_id(device_id):
            raise WireError(f"{shown(device_id)} is not a valid device id")
        name = f"{domain}/5/{device_id}"
        if not payload:
            return self._removed(name, attribute)
        device = self.devices.get(name)
        if device is None:
            device = _Homie5Device()
            if not self.devices.add(name, device):
                return ()
        read = self._on_state if attribute == "$state" else self._on_document
        document = read(device, domain, device_id, payload)
        if document is None:
            return ()
        self.ignored += document.ignored
        return self.announce(device, document.device, domain, device.state)

    def _on_state(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> Document | None:
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

    def _on_document(self, device: _Homie5Device, domain: str, device_id: str, payload: bytes) -> Document | None:
        """Return a changed document that is effective now; invalid fields are reported in any case."""
        document_hash = hash(payload)
        if device.document_hash == document_hash:
            return None
        document = parse_document(domain, device_id, payload)
        self._release(device)
        device.document_hash = document_hash
        if device.is_ready:
            return document
        self._store(device, payload)
        return None

    def _store(self, device: _Homie5Device, payload: bytes) -> None:
        if self._waiting + len(payload) > _MAX_WAITING:
            device.document_hash = None
            self.refused += 1
            return
        device.waiting = payload
        self._waiting += len(payload)

    def _release(self, device: _Homie5Device) -> None:
        self._waiting -= len(device.waiting)
        device.waiting = b""

    def _removed(self, name: str, attribute: str) -> tuple[AnnouncementEvent, ...]:
        device = self.devices.get(name)
        if device is None:
            return ()
        self._release(device)
        if attribute == "$state":
            self.devices.remove(name)
            return self.withdraw(device, name, "its state was removed", is_final=True)
        device.document_hash = None
        return self.withdraw(device, name, "its description was removed")
