"""Devices as Thing Descriptions. Pure.

Facts without a term in TD are under ``homebot:``, so that a description that is read again gives the
same device.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, Protocol
from urllib.parse import quote

from homebot.devices.capabilities import CAPABILITIES, CapabilityType
from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.part import Capability
from homebot.wot.parse import CONTEXT
from homebot.wot.vocabulary import CAPABILITY_TYPES, DEVICE_TYPE_NAMES, WEBTHINGS

__all__ = ["FormWriter", "property_names", "thing_id", "to_thing"]

_MQTT_VOCABULARY: Final = "https://www.w3.org/2019/wot/mqtt#"
_OWN_VOCABULARY: Final = "urn:homebot:td#"
_JSON_TYPES = {"bool": "boolean", "number": "number", "text": "string", "numbers": "array"}


class FormWriter(Protocol):
    """A way to reach devices, which says where their properties are read and written."""

    def of_property(self, name: str, part: DevicePart, capability: Capability) -> list[dict[str, object]]:
        """Return the forms of the property *name*; none if it cannot be reached."""
        ...

    def of_words(self, endpoint: Endpoint) -> list[dict[str, object]]:
        """Return the forms for plain text to and from a device that has no parts."""
        ...


def thing_id(device_id: str, owner: str = "") -> str:
    """Return the id of a device's description.

    Args:
        device_id: The device's id.
        owner: The id of the homebot that describes it, where descriptions of several may meet; empty for none.
    """
    return f"urn:homebot:{owner}:{quote(device_id, safe='')}" if owner else f"urn:homebot:{quote(device_id, safe='')}"


def to_thing(device: Device, forms: FormWriter, owner: str = "") -> dict[str, object]:
    """Return the Thing Description 1.1 of *device*, as JSON values; it needs no credentials.

    It lists the properties that can be read and set, in the vocabulary's units, and their addresses.

    Args:
        device: The device.
        forms: The way to reach it.
        owner: See :func:`thing_id`.
    """
    properties = dict(_properties(device, forms))
    types = dict.fromkeys(
        DEVICE_TYPE_NAMES[one.part.service_type] for one in device.parts if one.part.service_type in DEVICE_TYPE_NAMES
    )
    thing: dict[str, object] = {
        "@context": [CONTEXT, WEBTHINGS, {"mqv": _MQTT_VOCABULARY, "homebot": _OWN_VOCABULARY}],
        "@type": ["Thing", *types],
        "id": thing_id(device.id, owner),
        "title": device.name.strip() or device.id,
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": "nosec_sc",
    }
    facts = {one.key: one.value for one in device.metadata} | {one.name: one.value for one in reversed(device.facts)}
    extension = {
        "homebot:area": device.area,
        "homebot:identifiers": list(device.identifiers),
        "homebot:facts": facts,
    }
    thing |= {name: value for name, value in extension.items() if value}
    return thing | {"properties": properties}


def property_names(device: Device) -> Iterator[tuple[str, DevicePart, Capability]]:
    """Yield the name of each property of *device* in its description, with its part and capability."""
    taken: set[str] = set()
    for part in device.parts:
        for capability in part.part.capabilities:
            name = _unused(f"{part.id}_{capability.name}" if part.id else capability.name, taken)
            yield name, part, capability


def _properties(device: Device, writer: FormWriter) -> Iterator[tuple[str, dict[str, object]]]:
    for name, part, capability in property_names(device):
        if forms := writer.of_property(name, part, capability):
            yield name, _property(part, capability, forms)
    if not device.parts:
        taken: set[str] = set()
        for endpoint in device.endpoints:
            if forms := writer.of_words(endpoint):
                yield _unused("words", taken), _plain_property(endpoint, forms)


def _property(part: DevicePart, capability: Capability, forms: list[dict[str, object]]) -> dict[str, object]:
    known = CAPABILITIES.get(capability.name, CapabilityType(capability.name, "text", capability.name))
    fields: dict[str, object] = {
        "title": f"{part.part.name} {capability.name}".strip(),
        "description": known.meaning,
        "type": _JSON_TYPES[known.kind],
        "readOnly": not capability.settable,
        "writeOnly": not capability.readable,
        "observable": _can_observe(forms),
    }
    if capability.name in CAPABILITY_TYPES:
        fields["@type"] = CAPABILITY_TYPES[capability.name]
    if unit := capability.unit or known.unit:
        fields["unit"] = unit
    if bounds := capability.bounds or known.bounds:
        fields |= {"minimum": bounds[0], "maximum": bounds[-1]}
    if options := capability.options or known.options:
        fields["enum"] = list(dict.fromkeys(options))
    own = {
        "capability": capability.name,
        "serviceType": part.part.service_type,
        "part": part.id,
        "name": part.part.name,
        "advertised": part.part.advertised,
        "tag": part.part.tag,
        "category": part.part.category,
        "guessed": "true" if part.part.guessed else "",
    }
    return fields | {f"homebot:{name}": value for name, value in own.items() if value} | {"forms": forms}


def _can_observe(forms: list[dict[str, object]]) -> bool:
    return any("observeproperty" in ops for one in forms if isinstance(ops := one["op"], list))


def _plain_property(endpoint: Endpoint, forms: list[dict[str, object]]) -> dict[str, object]:
    return {
        "title": "words",
        "description": "its states and commands as plain text",
        "type": "string",
        "readOnly": not endpoint.command_address,
        "observable": _can_observe(forms),
        "forms": forms,
    }


def _unused(name: str, taken: set[str]) -> str:
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    taken.add(found)
    return found
