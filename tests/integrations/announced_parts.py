"""Parts that a convention describes, of devices that are announced with a few fields."""

import json
from collections.abc import Callable, Iterable, Mapping

from homebot.conventions.convention import Convention
from homebot.conventions.description import AnnouncementEvent, DescribedPart, DeviceAnnounced
from homebot.conventions.installed_conventions import find_conventions
from homebot.devices import Sighting
from homebot.devices.value import PlainValue
from homebot.gateways.announced.announcement import StoredAnnouncement
from homebot.messages import Time

CONTEXT = "https://www.w3.org/2022/wot/td/v1.1"
NO_SECURITY = {"securityDefinitions": {"nosec_sc": {"scheme": "nosec"}}, "security": "nosec_sc"}

Say = Callable[..., tuple[AnnouncementEvent, ...]]


def spoken_to(convention: Convention, *, is_retained: bool = True) -> Say:
    """A function that reads a message; a payload that is no text is spelled in JSON."""

    def say(topic: str, payload: object, *, retained: bool = is_retained) -> tuple[AnnouncementEvent, ...]:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        return convention.read_message(topic, text.encode(), retained=retained)

    return say


def announced(convention: Convention, *messages: tuple[str, object]) -> list[DeviceAnnounced]:
    """The devices that *messages* announce, spelled as for :func:`spoken_to`."""
    heard = [one for topic, payload in messages for one in spoken_to(convention)(topic, payload)]
    return [one for one in heard if isinstance(one, DeviceAnnounced)]


def device_in(events: Iterable[AnnouncementEvent]) -> DeviceAnnounced:
    """The only one of *events*, a device that is announced."""
    (device,) = events
    assert isinstance(device, DeviceAnnounced)
    return device


def sighting(device: DeviceAnnounced) -> Sighting:
    """As the gateway ``mqtt`` publishes it, for an hour."""
    announcement = StoredAnnouncement("mqtt", device.full_key, device)
    begin, end = Time(sec=0, nanosec=0), Time(sec=3600, nanosec=0)
    return announcement.template.model_copy(update={"why": "it was announced", "seen_at": begin, "expires_at": end})


def part_with(capability: str, convention: Convention, *messages: tuple[str, object]) -> DescribedPart:
    """The only part with *capability*."""
    parts = [part for one in announced(convention, *messages) for part in one.parts]
    (found,) = [one for one in parts if capability in {each.name for each in one.part.capabilities}]
    return found


def part_in(events: Iterable[AnnouncementEvent], part_id: str) -> DescribedPart:
    """The part with *part_id* of the only device that is announced among *events*."""
    (device,) = [one for one in events if isinstance(one, DeviceAnnounced)]
    (found,) = [one for one in device.parts if one.part.id == part_id]
    return found


def heard(part: DescribedPart, topic: str, payload: object, *, retained: bool = False) -> dict[str, PlainValue]:
    """What *part* reads in a payload; one that is no text is spelled in JSON."""
    text = payload if isinstance(payload, str) else json.dumps(payload)
    return dict(part.codec.read(topic, text.encode(), retained=retained))


def told(part: DescribedPart, capability: str, value: PlainValue, transition: float = 0.0) -> list[tuple[str, str]]:
    """The topics and payloads of a command; none is kept by the broker."""
    publications = part.codec.write(capability, value, transition=transition)
    assert not any(one.retain for one in publications)
    return [(one.topic, one.payload.decode()) for one in publications]


def installed(name: str) -> Convention:
    """The convention of that name, with the usual settings; its integration may be taken out."""
    (convention,) = find_conventions((name,), {}, "")
    return convention


def homeassistant_parts(component: str, config: Mapping[str, object]) -> tuple[DescribedPart, ...]:
    """The parts of one config of Home Assistant's discovery."""
    message = (f"homeassistant/{component}/x/config", config)
    return tuple(part for one in announced(installed("homeassistant"), message) for part in one.parts)


def homeassistant_part(capability: str, component: str, config: Mapping[str, object]) -> DescribedPart:
    convention = installed("homeassistant")
    return part_with(capability, convention, (f"homeassistant/{component}/x/config", config))


def zigbee2mqtt_part(capability: str, expose: Mapping[str, object]) -> DescribedPart:
    entry = {
        "ieee_address": "0x00158d0001abcdef",
        "friendly_name": "a",
        "type": "Router",
        "supported": True,
        "interview_completed": True,
        "definition": {"model": "m", "vendor": "v", "description": "d", "exposes": [expose]},
    }
    return part_with(capability, installed("zigbee2mqtt"), ("zigbee2mqtt/bridge/devices", [entry]))


def homie_part(capability: str, properties: Mapping[str, object], node_type: str = "") -> DescribedPart:
    """Of the node ``homie/5/x/n``."""
    description = {"homie": "5.0", "version": 1, "nodes": {"n": {"type": node_type, "properties": properties}}}
    messages = (("homie/5/x/$description", description), ("homie/5/x/$state", "ready"))
    return part_with(capability, installed("homie"), *messages)


def thing_part(capability: str, types: str, schema: Mapping[str, object]) -> DescribedPart:
    """Of a thing with one property, reported on ``t`` and written on ``t/set``."""
    forms = [
        {"href": "mqtt://b", "op": "observeproperty", "mqv:filter": "t"},
        {"href": "mqtt://b", "op": "writeproperty", "mqv:topic": "t/set"},
    ]
    properties = {"p": {"@type": types, "forms": forms, **schema}}
    description = {"@context": CONTEXT, "title": "T", **NO_SECURITY, "properties": properties}
    return part_with(capability, installed("thing"), ("homebot/things/x/td", description))
