"""Reader of Homie's attributes, of all versions, and the devices of each. Pure, and bounded.

A device of version 5 describes itself in one document; it exists once that and its state are known and it is not
starting, and a new document becomes effective when it is ready again. One of version 4 or 3 is put together from single
retained topics: it is complete when every node it announces has its properties, every property its datatype, which is a
string by default in version 3, and its state is known and not ``init``.

Source: Homie convention 5, Device Lifecycle; Homie 4.0 and 3.0.1, Device, Node and Property Attributes; arrays: 3.0.1,
Arrays.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import ClassVar, Generic, TypeVar

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn
from homebot.conventions.payload import clean_text, parse_object, shown, to_text
from homebot.devices.identity import identifiers
from homebot.errors import WireError
from homebot.integrations.homie.formats.model import (
    DEVICE_ATTRIBUTES,
    MAX_PROPERTIES,
    NODE_ATTRIBUTES,
    PROPERTY_ATTRIBUTES,
    STATES,
    HomieDevice,
    availability_of,
)
from homebot.integrations.homie.formats.node_reader import optional, read_device
from homebot.integrations.homie.formats.parts import build_alert, build_parts

_MAX_PROBLEMS = 20


@dataclass(slots=True)
class RegisteredDevice:
    """A device of a registry; *size* is the memory that it takes."""

    is_described: bool = False
    size: int = 0

    @property
    def is_unfinished(self) -> bool:
        """True if it is not starting, and what it announces cannot be read as a whole."""
        return False


DeviceT = TypeVar("DeviceT", bound=RegisteredDevice)


class Registry(Generic[DeviceT]):
    """At most *most* devices by topic, of *memory* characters together; described ones are never dropped.

    Attributes:
        has_alert: Whether a state tells that a device needs a person.
        ignored: Number of invalid nodes and properties.
        refused: Number of refused attributes and documents.
    """

    has_alert: ClassVar[bool] = False

    def __init__(self, most: int, memory: int) -> None:
        self.ignored = 0
        self.refused = 0
        self.devices: BoundedDict[DeviceT] = BoundedDict(most, lambda device: self.reserve(device, 0))
        self._left = memory

    @property
    def dropped(self) -> int:
        """Number of dropped devices, attributes and documents."""
        return self.devices.dropped + self.refused

    def problems(self) -> tuple[str, ...]:
        """Return the first devices that did not finish announcing themselves, as if they had died meanwhile."""
        unfinished = (name for name, device in self.devices.items() if device.is_unfinished)
        words = "is announced in part, or so that it cannot be read: restart it, or delete its retained messages"
        return tuple(f"{name} {words}" for name in islice(unfinished, _MAX_PROBLEMS))

    def announce(self, device: DeviceT, whole: HomieDevice, domain: str, state: str) -> tuple[AnnouncementEvent, ...]:
        """Return the description of *device*, or its withdrawal if it has no parts."""
        self.ignored += whole.ignored
        described = _describe(whole, domain, is_alive=bool(STATES[state]), has_alert=self.has_alert)
        if described is None:
            return self.withdraw(device, whole.topic, "it no longer has any nodes")
        self.devices.pin(whole.topic)
        device.is_described = True
        return (described,)

    def withdraw(
        self, device: DeviceT, name: str, why: str, *, is_final: bool = False
    ) -> tuple[AnnouncementEvent, ...]:
        """Return the withdrawal of *device* if it was described."""
        was_described, device.is_described = device.is_described, False
        return (DeviceWithdrawn(name, why, is_final=is_final),) if was_described else ()

    def reserve(self, device: DeviceT, size: int) -> bool:
        """Let *device* take *size* of the memory; return False, and count that, if it is not there."""
        if size - device.size > self._left:
            self.refused += 1
            return False
        self._left -= size - device.size
        device.size = size
        return True


def _describe(device: HomieDevice, domain: str, *, is_alive: bool, has_alert: bool) -> DeviceAnnounced | None:
    """Return the description of *device*; None if it has no parts itself, as a bridge.

    Its identifier is its id in its domain, with a hardware address if the id ends with one. The ``$mac`` of version 4
    belongs to the publishing computer, perhaps of many devices.
    """
    parts = build_parts(device)
    if not parts:
        return None
    if has_alert:
        parts = (*parts, build_alert(device))
    return DeviceAnnounced(
        key=device.topic,
        convention="homie",
        native=True,
        whole_device=True,
        identifiers=identifiers((f"{domain}/{device.id}",)),
        name=device.name,
        parts=parts,
        topic=f"{device.topic}/$state",
        facts={**device.facts, **({"type": device.type} if device.type else {})},
        availability=availability_of(device.topic, device.root),
        owns=(device.topic,),
        implies_alive=is_alive,
    )


_MAX_ARRAY = 100
_LISTED = re.compile(r"[A-Za-z0-9_-]{1,100}(?:\[\])?")
_ARRAY = re.compile(r"([0-9]{1,5})-([0-9]{1,5})")


def _nodes(attributes: Mapping[str, str]) -> dict[str, object] | None:
    """Return the nodes of a device as documents of version 5 have them; None while an attribute is missing."""
    nodes: dict[str, object] = {}
    listed = _list(attributes.get("$nodes"))
    for name in listed or ():
        node_id = name.removesuffix("[]")
        elements = _elements(attributes, node_id) if name.endswith("[]") else (node_id,)
        properties = _properties(attributes, node_id)
        if elements is None or properties is None:
            return None
        shared = attributes.get(f"{node_id}/$name", "")
        for element in elements:
            numbered = shared and shared + element[len(node_id) :].replace("_", " ")
            nodes[element] = {
                "name": attributes.get(f"{element}/$name", numbered),
                "type": attributes.get(f"{node_id}/$type", ""),
                "properties": properties,
            }
    return None if listed is None else nodes


def _properties(attributes: Mapping[str, str], node_id: str) -> dict[str, object] | None:
    """Return the properties of a node; None while an attribute is missing. Version 3 needs no datatypes."""
    listed = _list(attributes.get(f"{node_id}/$properties"))
    has_default = attributes.get("$homie", "").startswith("3.")
    if listed is None or not (
        has_default or all(f"{node_id}/{property_id}/$datatype" in attributes for property_id in listed)
    ):
        return None
    return {property_id: _property(attributes, f"{node_id}/{property_id}") for property_id in listed}


def _elements(attributes: Mapping[str, str], node_id: str) -> tuple[str, ...] | None:
    match = _ARRAY.fullmatch(attributes.get(f"{node_id}/$array", ""))
    if match is None:
        return None
    first, last = int(match[1]), int(match[2])
    return tuple(f"{node_id}_{index}" for index in range(first, min(last, first + _MAX_ARRAY - 1) + 1))


def _property(attributes: Mapping[str, str], path: str) -> dict[str, object]:
    fields: dict[str, object] = {name: attributes.get(f"{path}/${name}", default) for name, default in _TEXTS}
    if fields["datatype"] == "boolean":
        del fields["format"]
    settable, retained = (attributes.get(f"{path}/${name}", "").casefold() for name in ("settable", "retained"))
    return {**fields, "settable": settable == "true", "retained": retained != "false"}


_TEXTS = (("name", ""), ("datatype", "string"), ("format", ""), ("unit", ""))
"""Attributes that are texts, with their defaults."""


def _list(text: str | None) -> tuple[str, ...] | None:
    """Return the valid ids of a list; None if it is missing."""
    if text is None:
        return None
    return tuple(dict.fromkeys(item for item in text.split(",") if _LISTED.fullmatch(item)))


_MAX_DEVICES_4 = 2000
_MAX_CHARACTERS = 16_000_000
_MAX_ATTRIBUTES = 6 * MAX_PROPERTIES
_MAX_VALUE_BYTES = 4000
_ID_4 = re.compile(r"[A-Za-z0-9_-]{1,100}")
_VERSION_4 = re.compile(r"[34]\.[0-9.]{1,20}")
_FACTS = {"$mac": "host_mac", "$fw/name": "firmware", "$fw/version": "sw_version", "$implementation": "model"}


@dataclass(slots=True)
class _Homie4Device(RegisteredDevice):
    attributes: dict[str, str] = field(default_factory=dict)
    is_changed: bool = True

    @property
    def is_unfinished(self) -> bool:
        """True if an attribute is missing and its state says that there is none to come."""
        is_starting = self.attributes.get("$state", "") in {"", "init"}
        return (
            self.is_changed and not is_starting and ("$homie" not in self.attributes or _nodes(self.attributes) is None)
        )


class Version4(Registry[_Homie4Device]):
    """Registry of the devices of versions 3 and 4.

    Of more than 2,000 devices the oldest incomplete one is dropped; of more than 16 million characters the newest.
    """

    has_alert = True

    def __init__(self) -> None:
        super().__init__(_MAX_DEVICES_4, _MAX_CHARACTERS)

    def read_attribute(
        self, domain: str, device_id: str, attribute: str, payload: bytes
    ) -> tuple[AnnouncementEvent, ...]:
        """Read the *attribute* of a device, its topic below the device's.

        Raises:
            WireError: It is illegal.
        """
        if not _is_known(attribute):
            return ()
        text = to_text(payload) if len(payload) <= _MAX_VALUE_BYTES else None
        if not _ID_4.fullmatch(device_id) or text is None:
            raise WireError(f"{shown(attribute)} of {shown(device_id)} is {shown(payload)}")
        name = f"{domain}/{device_id}"
        if not text and attribute in {"$state", "$homie"}:
            device = self.devices.remove(name)
            if device is None:
                return ()
            self.reserve(device, 0)
            return self.withdraw(device, name, "its state was removed", is_final=True)
        if attribute == "$state" and text not in STATES:
            raise WireError(f"$state is {shown(text)}, not one of {', '.join(STATES)}")
        if attribute == "$homie" and not _VERSION_4.fullmatch(text):
            raise WireError(f"$homie is {shown(text)}, not 3 or 4")
        device = self.devices.find(name, _Homie4Device)
        if device is None or not self._record(device, attribute, text) or not _may_be_complete(device, attribute):
            return ()
        return self._describe(device, domain, device_id)

    def _describe(self, device: _Homie4Device, domain: str, device_id: str) -> tuple[AnnouncementEvent, ...]:
        state = device.attributes.get("$state", "")
        if not device.is_changed or state in {"", "init"} or "$homie" not in device.attributes:
            return ()
        nodes = _nodes(device.attributes)
        if nodes is None:
            return ()
        device.is_changed = False
        attributes = device.attributes
        whole = read_device(
            {"name": attributes.get("$name", ""), "nodes": nodes},
            device_id,
            f"{domain}/{device_id}",
            _ID_4,
            facts={fact: text for key, fact in _FACTS.items() if (text := clean_text(attributes.get(key, "")))},
            names_form=False,
        )
        return self.announce(device, whole, domain, state)

    def _record(self, device: _Homie4Device, attribute: str, text: str) -> bool:
        known = device.attributes.get(attribute)
        if known == text:
            return attribute == "$state"
        grown = len(text) + len(attribute) - (0 if known is None else len(known) + len(attribute))
        if known is None and len(device.attributes) >= _MAX_ATTRIBUTES:
            self.refused += 1
            return False
        if not self.reserve(device, device.size + grown):
            return False
        device.attributes[attribute] = text
        device.is_changed = device.is_changed or attribute != "$state"
        return True


def _is_known(attribute: str) -> bool:
    if attribute in DEVICE_ATTRIBUTES:
        return True
    owner, _, name = attribute.rpartition("/")
    return bool(owner) and name in (NODE_ATTRIBUTES, PROPERTY_ATTRIBUTES, ())[min(owner.count("/"), 2)]


def _may_be_complete(device: _Homie4Device, attribute: str) -> bool:
    """Return whether *attribute* can complete the device, to skip the check for most of them."""
    return attribute == "$state" or device.is_described or ("$state" in device.attributes and attribute.endswith(_LAST))


_LAST = ("$datatype", "$format", "$properties", "$nodes", "$homie", "$array")


_ID_5 = re.compile(r"[a-z0-9-]{1,100}")
_VERSION_5 = re.compile(r"5\.[0-9]{1,5}")


def parse_document(domain: str, device_id: str, payload: bytes) -> HomieDevice:
    """Return the device that its ``$description`` describes.

    Raises:
        WireError: It is no document of Homie 5, or a field of the device itself is illegal.
    """
    fields = parse_object(payload)
    version = fields.get("homie")
    if not isinstance(version, str) or not _VERSION_5.fullmatch(version):
        raise WireError(f"homie is {shown(version)}, not 5.x")
    optional(fields, "version", int)
    for name in ("children", "extensions"):
        optional(fields, name, list)
    root = optional(fields, "root", str) or ""
    parent = optional(fields, "parent", str) or root
    if not all(_ID_5.fullmatch(relative) for relative in (root, parent) if relative):
        raise WireError(f"root is {shown(root)} and parent {shown(parent)}, not ids")
    root, parent = root if root != device_id else "", parent if parent != device_id else ""
    return read_device(
        fields,
        device_id,
        f"{domain}/5/{device_id}",
        _ID_5,
        root=f"{domain}/5/{root}" if root else "",
        facts={"via_device": parent} if parent else {},
    )


_MAX_DEVICES_5 = 5000
_MAX_WAITING_BYTES = 16_000_000


@dataclass(slots=True)
class _Homie5Device(RegisteredDevice):
    """State and document of one device; *waiting* is a document that the state makes ineffective."""

    state: str = ""
    document_hash: int | None = None
    waiting: bytes = b""

    @property
    def is_ready(self) -> bool:
        return self.state not in {"", "init"}

    @property
    def is_unfinished(self) -> bool:
        """True if it has no document, or the last one was illegal, and its state says that there is none to come."""
        return self.is_ready and self.document_hash is None


class Version5(Registry[_Homie5Device]):
    """Registry of the devices of version 5.

    Of more than 5,000 devices the oldest undescribed one is dropped; of more than 16 MB of waiting documents the
    newest.
    """

    def __init__(self) -> None:
        super().__init__(_MAX_DEVICES_5, _MAX_WAITING_BYTES)

    def read_attribute(
        self, domain: str, device_id: str, attribute: str, payload: bytes
    ) -> tuple[AnnouncementEvent, ...]:
        """Read an attribute of a device.

        Raises:
            WireError: It is illegal.
        """
        if not _ID_5.fullmatch(device_id):
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
        device.document_hash = None
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


class HomieReader:
    """Reader of the attributes of devices of any version, with bounded memory."""

    def __init__(self) -> None:
        self.rejected = 0
        self._version4 = Version4()
        self._version5 = Version5()

    @property
    def dropped(self) -> int:
        """Number of dropped devices and attributes."""
        return self._version4.dropped + self._version5.dropped

    @property
    def ignored(self) -> int:
        """Number of illegal nodes and properties, of devices that were described without them."""
        return self._version4.ignored + self._version5.ignored

    def problems(self) -> tuple[str, ...]:
        """Return the devices that did not finish announcing themselves."""
        return self._version4.problems() + self._version5.problems()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:  # noqa: ARG002 - the broker keeps all attributes
        """Read an attribute and return the description that it completes."""
        domain, _, rest = topic.partition("/")
        device_id, _, attribute = rest.partition("/")
        if device_id != "5":
            return self._version4.read_attribute(domain, device_id, attribute, payload)
        inner_id, _, inner = attribute.partition("/")
        if inner in {"$state", "$description"}:
            return self._version5.read_attribute(domain, inner_id, inner, payload)
        return ()
