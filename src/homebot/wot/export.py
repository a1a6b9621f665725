"""Devices as Thing Descriptions. Pure.

What homebot knows and TD has no word for stands under ``homebot:``, so that a description that is read again gives the
same device.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final
from urllib.parse import quote

from homebot.devices.capabilities import CAPABILITIES, CapabilityType
from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.names import read_text_address
from homebot.devices.part import Capability
from homebot.wot.parse import CONTEXT
from homebot.wot.payload import TEXT_CONTENT_TYPE
from homebot.wot.vocabulary import CAPABILITY_TYPES, DEVICE_TYPE_NAMES, WEBTHINGS

__all__ = ["MQTT_VOCABULARY", "own_content_type", "to_thing"]

MQTT_VOCABULARY: Final = "https://www.w3.org/2019/wot/mqtt#"
_OWN_VOCABULARY: Final = "urn:homebot:td#"
_JSON_TYPES = {"bool": "boolean", "number": "number", "text": "string", "numbers": "array"}


def own_content_type(convention: str) -> str:
    """Return the content type of payloads that a convention spells; without one they are plain words."""
    return f"application/vnd.homebot.{convention or 'words'}"


def to_thing(device: Device, brokers: Mapping[str, str]) -> dict[str, object]:
    """Return the Thing Description 1.1 of *device*, as JSON values.

    It says what can be read and set, in the vocabulary's units, and on which MQTT topics. Where a convention such as
    Zigbee2MQTT's says how that is spelt, the content type names it.

    Args:
        device: The device.
        brokers: Address of each gateway's broker, for example ``mqtt://192.168.1.10:1883``; any other is taken to be
            ``mqtt://localhost:1883``.
    """
    properties = dict(_properties(device, brokers))
    types = dict.fromkeys(
        DEVICE_TYPE_NAMES[one.part.service_type] for one in device.parts if one.part.service_type in DEVICE_TYPE_NAMES
    )
    thing: dict[str, object] = {
        "@context": [CONTEXT, WEBTHINGS, {"mqv": MQTT_VOCABULARY, "homebot": _OWN_VOCABULARY}],
        "@type": ["Thing", *types],
        "id": f"urn:homebot:{quote(device.id, safe='')}",
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


def _properties(device: Device, brokers: Mapping[str, str]) -> Iterator[tuple[str, dict[str, object]]]:
    taken: set[str] = set()
    for part in device.parts:
        for capability in part.part.capabilities:
            forms = list(_forms(part, capability, brokers))
            if forms:
                name = _unused(f"{part.id}_{capability.name}" if part.id else capability.name, taken)
                yield name, _property(part, capability, forms)
    if not device.parts:
        for endpoint in device.endpoints:
            forms = list(_plain_forms(endpoint, brokers))
            if forms:
                yield _unused("words", taken), _plain_property(endpoint, forms)


def _property(part: DevicePart, capability: Capability, forms: list[dict[str, object]]) -> dict[str, object]:
    known = CAPABILITIES.get(capability.name, CapabilityType(capability.name, "text", capability.name))
    fields: dict[str, object] = {
        "title": f"{part.part.name} {capability.name}".strip(),
        "description": known.meaning,
        "type": _JSON_TYPES[known.kind],
        "readOnly": not capability.settable,
        "writeOnly": not capability.readable,
        "observable": capability.readable,
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


def _forms(part: DevicePart, capability: Capability, brokers: Mapping[str, str]) -> Iterator[dict[str, object]]:
    best = part.routes[0] if part.routes else None
    broker = brokers.get(best.gateway if best else "", "mqtt://localhost:1883")
    content = own_content_type(best.convention if best else "")
    if capability.readable:
        yield from (_form(broker, content, observed=topic) for topic in part.part.reads)
    if capability.settable:
        yield from (_form(broker, content, written=topic) for topic in part.part.writes)


def _plain_property(endpoint: Endpoint, forms: list[dict[str, object]]) -> dict[str, object]:
    return {
        "title": "words",
        "description": "its states and commands as plain text",
        "type": "string",
        "readOnly": not endpoint.command_address,
        "observable": True,
        "forms": forms,
    }


def _plain_forms(endpoint: Endpoint, brokers: Mapping[str, str]) -> Iterator[dict[str, object]]:
    broker = brokers.get(endpoint.gateway, "mqtt://localhost:1883")
    if endpoint.address and read_text_address(endpoint.address) is None:
        yield _form(broker, TEXT_CONTENT_TYPE, observed=endpoint.address)
    if endpoint.command_address and read_text_address(endpoint.command_address) is None:
        yield _form(broker, TEXT_CONTENT_TYPE, written=endpoint.command_address)


def _form(broker: str, content: str, *, observed: str = "", written: str = "") -> dict[str, object]:
    """Return a form to observe rather than to read: whether the broker retains it is not known."""
    if observed:
        return {
            "href": broker,
            "contentType": content,
            "op": ["observeproperty", "unobserveproperty"],
            "mqv:controlPacket": "subscribe",
            "mqv:filter": observed,
        }
    return {
        "href": broker,
        "contentType": content,
        "op": "writeproperty",
        "mqv:controlPacket": "publish",
        "mqv:topic": written,
    }


def _unused(name: str, taken: set[str]) -> str:
    found, number = name, 1
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    taken.add(found)
    return found
