"""Devices as Thing Descriptions. Pure.

Facts without a term in TD are in ``homebot:``, so that reading a description again gives the same device.
"""

from collections.abc import Iterator, Mapping
from typing import Final, Protocol
from urllib.parse import quote

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.capability_type import CapabilityType
from homebot.devices.device import Device, DevicePart, Endpoint, Route
from homebot.devices.names import read_text_address
from homebot.devices.part import Capability
from homebot.integrations.things.formats.parse import CONTEXT
from homebot.integrations.things.formats.payload import TEXT_CONTENT_TYPE
from homebot.integrations.things.formats.thing import NO_SECURITY
from homebot.integrations.things.formats.vocabulary import CAPABILITY_TYPES, DEVICE_TYPE_NAMES, WEBTHINGS

__all__ = ["FormWriter", "MqttForms", "property_names", "thing_id", "to_thing"]

_MQTT_VOCABULARY: Final = "https://www.w3.org/2019/wot/mqtt#"
_OWN_VOCABULARY: Final = "urn:homebot:td#"
_NO_ROUTE: Final = Route(gateway="", key="", part="")
_LOCAL: Final = "mqtt://localhost:1883"
_IN_PATH: Final = "/!$&'()*+,:;=@"  # RFC 3986, section 3.3
_JSON_TYPES = {"bool": "boolean", "number": "number", "text": "string", "numbers": "array"}


class FormWriter(Protocol):
    """A protocol by which properties of devices are read and written."""

    def of_property(self, name: str, part: DevicePart, capability: Capability) -> list[dict[str, object]]:
        """Return the forms of the property *name*; empty if it is not reachable."""

    def of_words(self, endpoint: Endpoint) -> list[dict[str, object]]:
        """Return the forms for plain text to and from a device without parts."""


def thing_id(device_id: str, owner: str = "") -> str:
    """Return the id of a device's description.

    Args:
        owner: The id of the homebot that describes it, if there may be several; empty for none.
    """
    return f"urn:homebot:{owner}:{quote(device_id, safe='')}" if owner else f"urn:homebot:{quote(device_id, safe='')}"


def to_thing(device: Device, forms: FormWriter, owner: str = "") -> dict[str, object]:
    """Return the Thing Description 1.1 of *device* as JSON values, without security.

    It lists the readable and settable properties, in the vocabulary's units, and their addresses.
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
        **NO_SECURITY,
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


def _own_content_type(convention: str) -> str:
    """Return the content type of a convention's payloads; without a convention, plain words."""
    return f"application/vnd.homebot.{convention or 'words'}"


class MqttForms:
    """The topics of devices.

    If a convention such as Zigbee2MQTT's defines the payloads, the content type names it.

    Args:
        brokers: Addresses of brokers by gateway, for example ``mqtt://192.168.1.10:1883``; by default
            ``mqtt://localhost:1883``.
    """

    def __init__(self, brokers: Mapping[str, str]) -> None:
        self._brokers = brokers

    def of_property(self, _name: str, part: DevicePart, capability: Capability) -> list[dict[str, object]]:
        """Return the forms of a property: the topics of its part."""
        best = part.routes[0] if part.routes else _NO_ROUTE
        broker, content = self._brokers.get(best.gateway, _LOCAL), _own_content_type(best.convention)
        forms: list[dict[str, object]] = []
        if capability.readable:
            forms += [_form(broker, content, observed=topic) for topic in part.part.reads]
        if capability.settable:
            forms += [_form(broker, content, written=topic) for topic in part.part.writes]
        return forms

    def of_words(self, endpoint: Endpoint) -> list[dict[str, object]]:
        """Return the forms for plain text: the topics of the device."""
        broker = self._brokers.get(endpoint.gateway, _LOCAL)
        forms: list[dict[str, object]] = []
        if endpoint.address and read_text_address(endpoint.address) is None:
            forms.append(_form(broker, TEXT_CONTENT_TYPE, observed=endpoint.address))
        if endpoint.command_address and read_text_address(endpoint.command_address) is None:
            forms.append(_form(broker, TEXT_CONTENT_TYPE, written=endpoint.command_address))
        return forms


def _form(broker: str, content: str, *, observed: str = "", written: str = "") -> dict[str, object]:
    """Return a form to observe rather than to read: whether the broker retains it is not known.

    The topic is in the address as well: consumers such as node-wot look for it there alone.
    """
    href = f"{broker.rstrip('/')}/{quote(observed or written, safe=_IN_PATH)}"
    if observed:
        return {
            "href": href,
            "contentType": content,
            "op": ["observeproperty", "unobserveproperty"],
            "mqv:controlPacket": "subscribe",
            "mqv:filter": observed,
        }
    return {
        "href": href,
        "contentType": content,
        "op": "writeproperty",
        "mqv:controlPacket": "publish",
        "mqv:topic": written,
    }
