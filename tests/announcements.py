"""Announcements of devices: what a test does not name is that of a lamp on MQTT."""

from typing import Any

from homebot.devices import Sighting
from homebot.devices.part import Capability, Part
from homebot.messages import Time

LAMP = Part(id="l", service_type="light", capabilities=(Capability(name="on_off", settable=True),))


def sighting_of(key: str, *parts: Part, at: float = 0.0, lasts: float = 3600.0, **fields: Any) -> Sighting:
    """Return a sighting of *key* at *at* seconds that expires *lasts* seconds later."""
    usual: dict[str, Any] = {
        "gateway": "mqtt",
        "kind": "updated",
        "why": "it was announced",
        "name": "Lamp",
        "service_type": parts[0].service_type if parts else "light",
        "address": "",
        "command_address": "",
        "seen_at": Time.from_seconds(at),
        "expires_at": Time.from_seconds(at + lasts),
        "confirmed": True,
    }
    return Sighting(key=key, parts=parts, **(usual | fields))
