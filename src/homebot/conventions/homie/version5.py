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

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceWithdrawn
from homebot.conventions.homie.model import (
    COLOR_FORMS,
    DATATYPES,
    MAX_PROPERTIES,
    STATES,
    HomieDevice,
    HomieNode,
    HomieProperty,
    Range,
    parse_options,
    parse_range,
)
from homebot.conventions.homie.parts import describe
from homebot.conventions.payload import clean_text, parse_object, shown
from homebot.errors import WireError

__all__ = ["Document", "Version5", "parse_document"]


T = TypeVar("T")

_ID = re.compile(r"[a-z0-9-]{1,100}")
_VERSION = re.compile(r"5\.[0-9]{1,5}")
_LONGEST_TYPE = 200
_LONGEST_UNIT = 20


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
        datatype = _optional(fields, "datatype", str)
        if datatype not in DATATYPES:
            raise WireError(f"datatype is {shown(datatype)}")
        spelled = _optional(fields, "format", str) or ""
        return HomieProperty(
            id=name,
            name=clean_text(_optional(fields, "name", str) or ""),
            datatype=datatype,
            topic=f"{self._topic}/{node_id}/{name}",
            unit=clean_text(_optional(fields, "unit", str) or "", _LONGEST_UNIT),
            range=parse_range(spelled) if datatype in {"integer", "float"} else Range(),
            options=_options(datatype, spelled),
            is_settable=_optional(fields, "settable", bool) or False,
            is_retained=_optional(fields, "retained", bool) is not False,
        )


def _options(datatype: str, spelled: str) -> tuple[str, ...]:
    if datatype not in {"enum", "color", "boolean"} or (datatype == "boolean" and not spelled):
        return ()
    options = parse_options(spelled)
    if datatype == "color" and not set(options) <= set(COLOR_FORMS):
        raise WireError(f"format {shown(spelled)} names no colour formats")
    if datatype == "boolean":
        if len(options) != len(("false", "true")):
            raise WireError(f"format {shown(spelled)} does not name false and true")
        return ()
    return options


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
class _Homie5Device:
    """State and document of one device; *waiting* is a document that the state makes ineffective."""

    state: str = ""
    document_hash: int | None = None
    waiting: bytes = b""
    is_described: bool = False

    @property
    def is_ready(self) -> bool:
        return self.state not in {"", "init"}


class Version5:
    """Registry of the devices of version 5.

    Of more than 5,000 devices the oldest undescribed one is dropped; of more than 16 MB of waiting documents the
    newest.

    Attributes:
        ignored: Number of invalid nodes and properties.
    """

    def __init__(self) -> None:
        self.ignored = 0
        self._devices: BoundedDict[_Homie5Device] = BoundedDict(_MAX_DEVICES, self._release)
        self._waiting = 0
        self._refused = 0

    @property
    def dropped(self) -> int:
        """Number of dropped devices and documents."""
        return self._devices.dropped + self._refused

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
        device = self._devices.get(name)
        if device is None:
            device = _Homie5Device()
            if not self._devices.add(name, device):
                return ()
        read = self._on_state if attribute == "$state" else self._on_document
        document = read(device, domain, device_id, payload)
        return () if document is None else self._describe(device, name, domain, document)

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
            return (DeviceWithdrawn(name, "it no longer has any nodes"),) if was_described else ()
        self._devices.pin(name)
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
