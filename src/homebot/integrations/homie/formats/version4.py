"""Devices of Homie 4 and 3, put together from single retained topics. Pure.

A device is complete when every node it announces has its properties, every property its datatype, which is a string by
default in version 3, and its state is known and not ``init``.

Source: Homie 4.0 and 3.0.1, Device, Node and Property Attributes; arrays: 3.0.1, Arrays.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import AnnouncementEvent
from homebot.conventions.payload import clean_text, shown, to_text
from homebot.errors import WireError
from homebot.integrations.homie.formats.model import (
    DEVICE_ATTRIBUTES,
    MAX_PROPERTIES,
    NODE_ATTRIBUTES,
    PROPERTY_ATTRIBUTES,
    STATES,
)
from homebot.integrations.homie.formats.node_reader import read_device
from homebot.integrations.homie.formats.registry import RegisteredDevice, Registry

_MAX_ARRAY = 100
_LISTED = re.compile(r"[A-Za-z0-9_-]{1,100}(?:\[\])?")
_ARRAY = re.compile(r"([0-9]{1,5})-([0-9]{1,5})")


def _nodes(attributes: Mapping[str, str]) -> dict[str, object] | None:
    """Return the nodes of a device as documents of version 5 have them; None while an attribute is missing."""
    nodes: dict[str, object] = {}
    listed = _listed(attributes.get("$nodes"))
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
    listed = _listed(attributes.get(f"{node_id}/$properties"))
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


def _listed(text: str | None) -> tuple[str, ...] | None:
    """Return the valid ids of a list; None if it is missing."""
    if text is None:
        return None
    return tuple(dict.fromkeys(item for item in text.split(",") if _LISTED.fullmatch(item)))


_MAX_DEVICES = 2000
_MAX_CHARACTERS = 16_000_000
_MAX_ATTRIBUTES = 6 * MAX_PROPERTIES
_MAX_VALUE_BYTES = 4000
_ID = re.compile(r"[A-Za-z0-9_-]{1,100}")
_VERSION = re.compile(r"[34]\.[0-9.]{1,20}")
_FACTS = {"$mac": "host_mac", "$fw/name": "firmware", "$fw/version": "sw_version", "$implementation": "model"}


@dataclass(slots=True)
class _Homie4Device(RegisteredDevice):
    attributes: dict[str, str] = field(default_factory=dict)
    is_changed: bool = True


class Version4(Registry[_Homie4Device]):
    """Registry of the devices of versions 3 and 4.

    Of more than 2,000 devices the oldest incomplete one is dropped; of more than 16 million characters the newest.
    """

    def __init__(self) -> None:
        super().__init__(_MAX_DEVICES, _MAX_CHARACTERS)

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
        if not _ID.fullmatch(device_id) or text is None:
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
        if attribute == "$homie" and not _VERSION.fullmatch(text):
            raise WireError(f"$homie is {shown(text)}, not 3 or 4")
        device = self.devices.find(name, _Homie4Device)
        if device is None or not self._record(device, attribute, text) or not _may_be_complete(device, attribute):
            return ()
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
            _ID,
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
