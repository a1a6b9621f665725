"""Thing Descriptions on tags, in codes and in files, and devices as such descriptions. Pure.

Facts without a term in TD are in ``homebot:``, so that reading a description again gives the same device.
"""

from collections.abc import Iterator, Mapping
from typing import Final
from urllib.parse import quote

from homebot.conventions.described_thing import DescribedThing
from homebot.conventions.payload import clean_text
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.capability_type import CapabilityType
from homebot.devices.device import Device, DevicePart, Endpoint, Route
from homebot.devices.names import read_text_address
from homebot.devices.part import Capability
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.payload import TEXT_CONTENT_TYPE
from homebot.integrations.things.formats.thing import NO_SECURITY, facts_of, identifiers_of
from homebot.integrations.things.formats.vocabulary import CAPABILITY_TYPES, DEVICE_TYPE_NAMES, WEBTHINGS

_MQTT_VOCABULARY: Final = "https://www.w3.org/2019/wot/mqtt#"
_OWN_VOCABULARY: Final = "urn:homebot:td#"
_NO_ROUTE: Final = Route(gateway="", key="", part="")
_LOCAL: Final = "mqtt://localhost:1883"
_IN_PATH: Final = "/!$&'()*+,:;=@"  # RFC 3986, section 3.3
_JSON_TYPES = {"bool": "boolean", "number": "number", "text": "string", "numbers": "array"}


def to_thing(device: Device, brokers: Mapping[str, str]) -> dict[str, object]:
    """Return the Thing Description 1.1 of *device* as JSON values, without security.

    It lists the readable and settable properties, in the vocabulary's units, and their topics. If a convention such as
    Zigbee2MQTT's defines the payloads, the content type names it.

    Args:
        brokers: Addresses of brokers by gateway, for example ``mqtt://192.168.1.10:1883``; by default
            ``mqtt://localhost:1883``.
    """
    types = [DEVICE_TYPE_NAMES.get(part.part.service_type) for part in device.parts]
    thing: dict[str, object] = {
        "@context": [CONTEXT, WEBTHINGS, {"mqv": _MQTT_VOCABULARY, "homebot": _OWN_VOCABULARY}],
        "@type": ["Thing", *dict.fromkeys(filter(None, types))],
        "id": f"urn:homebot:{quote(device.id, safe='')}",
        "title": device.name.strip() or device.id,
        **NO_SECURITY,
    }
    facts = {fact.key: fact.value for fact in device.metadata} | {
        fact.name: fact.value for fact in reversed(device.facts)
    }
    extension = {
        "homebot:area": device.area,
        "homebot:identifiers": list(device.identifiers),
        "homebot:facts": facts,
    }
    thing |= {name: value for name, value in extension.items() if value}
    return thing | {"properties": dict(_properties(device, brokers))}


def _properties(device: Device, brokers: Mapping[str, str]) -> Iterator[tuple[str, dict[str, object]]]:
    taken: set[str] = set()
    for part in device.parts:
        for capability in part.part.capabilities:
            name = _unused(f"{part.id}_{capability.name}" if part.id else capability.name, taken)
            best = part.routes[0] if part.routes else _NO_ROUTE
            broker, content = brokers.get(best.gateway, _LOCAL), f"application/vnd.homebot.{best.convention or 'words'}"
            observed = part.part.reads if capability.readable else ()
            written = part.part.writes if capability.settable else ()
            forms = [
                *(_observing(broker, content, topic) for topic in observed),
                *(_writing(broker, content, topic) for topic in written),
            ]
            if forms:
                yield name, _property(part, capability, forms)
    for endpoint in () if device.parts else device.endpoints:
        if forms := _forms_of_text(endpoint, brokers):
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
    return any("observeproperty" in ops for form in forms if isinstance(ops := form["op"], list))


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
    spelt, number = name, 1
    while spelt in taken:
        number += 1
        spelt = f"{name}_{number}"
    taken.add(spelt)
    return spelt


def _forms_of_text(endpoint: Endpoint, brokers: Mapping[str, str]) -> list[dict[str, object]]:
    """Return the forms for plain text to and from a device without parts."""
    broker = brokers.get(endpoint.gateway, _LOCAL)
    makers = {_observing: endpoint.address, _writing: endpoint.command_address}
    topics = [(make, topic) for make, topic in makers.items() if topic and read_text_address(topic) is None]
    return [make(broker, TEXT_CONTENT_TYPE, topic) for make, topic in topics]


def _observing(broker: str, content: str, topic: str) -> dict[str, object]:
    """Return a form to observe rather than to read: whether the broker retains it is not known."""
    terms = {"op": ["observeproperty", "unobserveproperty"], "mqv:controlPacket": "subscribe", "mqv:filter": topic}
    return {"href": _address(broker, topic), "contentType": content, **terms}


def _writing(broker: str, content: str, topic: str) -> dict[str, object]:
    terms = {"op": "writeproperty", "mqv:controlPacket": "publish", "mqv:topic": topic}
    return {"href": _address(broker, topic), "contentType": content, **terms}


def _address(broker: str, topic: str) -> str:
    """Return an address with the topic as well: consumers such as node-wot look for it there alone."""
    return f"{broker.rstrip('/')}/{quote(topic, safe=_IN_PATH)}"


class ThingDocuments:
    """The format W3C Thing Description 1.1; see :class:`homebot.conventions.described_thing.ThingFormat`."""

    def read(self, document: object) -> DescribedThing:
        """Return the described thing; raise WireError if it is invalid."""
        thing = read_thing(document)
        title, area = clean_text(thing.title), clean_text(thing.area)
        return DescribedThing(thing.id, title, area, identifiers_of(thing), facts_of(thing))

    def describe(self, device: Device, brokers: Mapping[str, str]) -> dict[str, object]:
        """Return the description of *device*, with its topics at the *brokers*."""
        return to_thing(device, brokers)
