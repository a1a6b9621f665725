"""The document in which a device of Homie 5 describes itself. Pure.

What the convention does not know is passed over; where something it knows is illegal, the property, the node or the
whole device is, whichever it belongs to.

Source: Homie convention 5, Device Attributes ($description), Nodes, Properties.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from homebot.conventions.homie.formats import COLOR_FORMS, DATATYPES, Range, parse_options, parse_range
from homebot.conventions.homie.model import MAX_PROPERTIES, HomieDevice, HomieNode, HomieProperty
from homebot.conventions.payload import clean_text, parse_object, shown
from homebot.errors import WireError

__all__ = ["Document", "is_id", "parse_document"]

T = TypeVar("T")

_ID = re.compile(r"[a-z0-9-]{1,100}")
_VERSION = re.compile(r"5\.[0-9]{1,5}")
_LONGEST_TYPE = 200
_LONGEST_UNIT = 20


@dataclass(frozen=True, slots=True)
class Document:
    """A description.

    Attributes:
        device: What it describes.
        ignored: Nodes and properties that were illegal.
    """

    device: HomieDevice
    ignored: int


def is_id(text: str) -> bool:
    """Return whether *text* is an id: small letters, digits and hyphens."""
    return _ID.fullmatch(text) is not None


def parse_document(domain: str, device_id: str, payload: bytes) -> Document:
    """Return what a device says in its ``$description``.

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
    root = _optional(fields, "root", str) or ""
    parent = _optional(fields, "parent", str) or root
    if not all(is_id(one) for one in (root, parent) if one):
        raise WireError(f"root is {shown(root)} and parent {shown(parent)}, not ids")
    topic = f"{domain}/5/{device_id}"
    reader = _DocumentReader(topic)
    nodes = reader.nodes(_optional(fields, "nodes", dict) or {})
    device = HomieDevice(
        id=device_id,
        name=clean_text(_optional(fields, "name", str) or "") or device_id,
        type=(_optional(fields, "type", str) or "")[:_LONGEST_TYPE],
        topic=topic,
        nodes=nodes,
        root=f"{domain}/5/{root}" if root and root != device_id else "",
        facts={"via_device": parent} if parent and parent != device_id else {},
    )
    return Document(device, reader.ignored)


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
        raise WireError(f"format {shown(spelled)} has no forms of a colour")
    if datatype == "boolean":
        if len(options) != len(("false", "true")):
            raise WireError(f"format {shown(spelled)} does not name false and true")
        return ()
    return options


def _optional(fields: Mapping[str, object], name: str, kind: type[T]) -> T | None:
    """Return a field; None where it is not there.

    Raises:
        WireError: It is of another kind. A truth is no number.
    """
    if name not in fields:
        return None
    value = fields[name]
    if isinstance(value, kind) and (kind is bool or not isinstance(value, bool)):
        return value
    raise WireError(f"{name} is {shown(value)}, not a {kind.__name__}")


def _legal_id(value: str) -> str:
    if is_id(value):
        return value
    raise WireError(f"{shown(value)} is no id")
