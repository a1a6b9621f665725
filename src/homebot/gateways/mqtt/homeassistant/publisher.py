"""The other direction: what homebot offers, as configs and states that a Home Assistant understands. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: binary_sensor.py, button.py, select.py, sensor.py, switch.py.
"""

from __future__ import annotations

import hashlib
import json
import re

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.command import Command
from homebot.devices.offer import Offer
from homebot.devices.part import Capability, Part
from homebot.devices.report import Reading
from homebot.devices.value import PlainValue, Value
from homebot.gateways.mqtt.description import Publication

__all__ = ["HomeAssistantPublisher"]

_PRESSED = frozenset({"push", "scene", "locate"})
_MAX_COMMAND = 1000


class HomeAssistantPublisher:
    """One config for each capability of what is offered, all of them retained, as its states are.

    Args:
        prefix: The discovery prefix.
        owner: Which homebot this is: lasting, and unique in the house.
        status_topic: Where that says ``online`` and ``offline``.
    """

    def __init__(self, prefix: str, owner: str, status_topic: str) -> None:
        self._prefix = prefix
        self._owner = f"homebot_{_slug(owner)}"
        self._base = f"homebot/{_slug(owner)}/offers"
        self._status_topic = status_topic
        self._settable: dict[str, tuple[str, str, Capability]] = {}

    def filters(self) -> tuple[str, ...]:
        """Return where Home Assistant's commands come."""
        return (f"{self._base}/+/+/+/set",)

    def owns(self, topic: str) -> bool:
        """Whether *topic* holds a config of this homebot, which it must not take for a device."""
        return topic.startswith(f"{self._prefix}/") and f"/{self._owner}/" in topic

    def publications(self, offer: Offer) -> tuple[Publication, ...]:
        """Return what makes *offer* be there, or be gone where it is withdrawn."""
        return tuple(
            self._config(offer, part, capability, component)
            for part in offer.parts
            for capability in part.capabilities
            if (component := _component(capability))
        )

    def states(self, offer: Offer, readings: tuple[Reading, ...]) -> tuple[Publication, ...]:
        """Return what tells *readings* of *offer*; what is unknown is told as ``None``."""
        known = {(part.id, one.name) for part in offer.parts for one in part.capabilities if one.readable}
        return tuple(
            Publication(
                f"{self._topic(offer.id, one.part, one.capability)}/state",
                _spoken(one.value.plain()).encode(),
                qos=1,
                retain=True,
            )
            for one in readings
            if (one.part, one.capability) in known
        )

    def take(self, topic: str, payload: bytes) -> Command | None:
        """Return the command that a message on one of the filters is; None where it is none."""
        target = self._settable.get(topic.removesuffix("/set"))
        if target is None or len(payload) > _MAX_COMMAND:
            return None
        offer_id, part_id, capability = target
        meant = _meant(capability, payload)
        if meant is None:
            return None
        return Command(key=offer_id, part=part_id, capability=capability.name, value=Value.of(meant))

    def _config(self, offer: Offer, part: Part, capability: Capability, component: str) -> Publication:
        topic = self._topic(offer.id, part.id, capability.name)
        object_id = "_".join(_slug(one) for one in (offer.id, part.id, capability.name) if one)
        where = f"{self._prefix}/{component}/{self._owner}/{object_id}/config"
        if offer.is_withdrawn:
            self._settable.pop(topic, None)
            return Publication(where, b"", qos=1, retain=True)
        config: dict[str, object] = {
            "name": " ".join(one for one in (part.name, _title(capability.name)) if one),
            "unique_id": f"{self._owner}_{object_id}",
            "device": self._device(offer),
            "origin": {"name": "homebot"},
            "availability_topic": self._status_topic,
        }
        if part.category:
            config["entity_category"] = part.category
        if component != "button":
            config["state_topic"] = f"{topic}/state"
        if capability.settable:
            config["command_topic"] = f"{topic}/set"
            self._settable[topic] = (offer.id, part.id, capability)
        config |= _details(capability, component)
        return Publication(where, json.dumps(config, ensure_ascii=False).encode(), qos=1, retain=True)

    def _device(self, offer: Offer) -> dict[str, object]:
        facts = {
            "identifiers": [f"{self._owner}_{_slug(offer.id)}"],
            "name": offer.name,
            "manufacturer": "homebot",
            "model": offer.model,
            "suggested_area": offer.area,
        }
        return {key: value for key, value in facts.items() if value}

    def _topic(self, offer_id: str, part_id: str, capability: str) -> str:
        return f"{self._base}/{_slug(offer_id)}/{_slug(part_id) or '_'}/{_slug(capability)}"


def _component(capability: Capability) -> str:
    """What shows the capability; empty for one that nothing can show."""
    known = CAPABILITIES.get(capability.name)
    if known is None or known.kind == "numbers":
        return ""
    if capability.settable:
        if capability.name in _PRESSED:
            return "button"
        if known.kind == "text":
            return "select" if capability.options or known.options else "text"
        return {"bool": "switch", "number": "number"}[known.kind]
    return "binary_sensor" if known.kind == "bool" else "sensor"


def _details(capability: Capability, component: str) -> dict[str, object]:
    known = CAPABILITIES[capability.name]
    details: dict[str, object] = {}
    if component in {"number", "sensor"} and (unit := capability.unit or known.unit):
        details["unit_of_measurement"] = unit
    bounds = capability.bounds or known.bounds
    if component == "number" and bounds:
        details |= {"min": bounds[0], "max": bounds[1]}
    if component == "select":
        details["options"] = list(capability.options or known.options)
    return details


def _spoken(value: PlainValue) -> str:
    match value:
        case None:
            return "None"
        case bool():
            return "ON" if value else "OFF"
        case float():
            return f"{value:g}" if abs(value) < 1e6 else repr(value)
        case tuple():
            return ",".join(f"{one:g}" for one in value)
        case _:
            return value


def _meant(capability: Capability, payload: bytes) -> PlainValue:
    """None for what is no value of *capability*."""
    try:
        text = payload.decode()
    except UnicodeDecodeError:
        return None
    known = CAPABILITIES[capability.name]
    if known.kind == "bool":
        return {"ON": True, "OFF": False, "PRESS": True}.get(text)
    if known.kind == "text":
        options = capability.options or known.options
        return text if not options or text in options else None
    try:
        number = float(text)
    except ValueError:
        return None
    low, high = capability.bounds or known.bounds or (-1e15, 1e15)
    return number if low <= number <= high else None


def _title(name: str) -> str:
    return name.replace("_", " ")


def _slug(text: str) -> str:
    """Letters, digits and ``_`` alone; what other characters it had stays told apart by a checksum."""
    slug = re.sub("[^a-zA-Z0-9]+", "_", text).strip("_")
    if slug == text:
        return slug
    return f"{slug}_{hashlib.sha256(text.encode()).hexdigest()[:6]}" if text else ""
