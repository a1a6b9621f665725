"""A Homie device as the gateway takes it. Pure."""

from __future__ import annotations

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.homie.model import HomieDevice
from homebot.conventions.homie.parts import build_parts
from homebot.conventions.homie.state import availability_of
from homebot.devices.identity import identifiers

__all__ = ["describe"]


def describe(device: HomieDevice, domain: str, *, is_alive: bool) -> DeviceAnnounced | None:
    """Return the description of *device*; None where it offers nothing itself, as a bridge does.

    Who it is, is its id in its domain: a hardware address counts where the id ends with one. The ``$mac`` of version 4
    is that of the computer that speaks for it, and perhaps for many.
    """
    parts = build_parts(device)
    if not parts:
        return None
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
