"""What a convention knows: how one family of devices uses MQTT topics. Pure: topics in, values out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from homebot.devices import KeyValue

__all__ = ["Announcement", "Convention"]


@dataclass(frozen=True, slots=True)
class Announcement:
    """What a topic tells about the device that uses it.

    Attributes:
        key: What the gateway calls the device; unique at the gateway.
        name: What people call it.
        service_type: What it offers.
        address: The topic it speaks on.
        command_address: The topic it listens on; empty when it takes no commands.
        metadata: Further facts.
    """

    key: str
    name: str
    service_type: str
    address: str
    command_address: str
    metadata: tuple[KeyValue, ...] = ()


class Convention(Protocol):
    """One way of using topics; found by the entry-point group ``homebot.mqtt_conventions``."""

    def filters(self) -> tuple[str, ...]:
        """Return the topic filters to subscribe to; no command topic of the convention may match them."""
        ...

    def announced(self, topic: str) -> Announcement | None:
        """Return the device that speaks on *topic*, or None when the topic is none of this convention's.

        Raises:
            WireError: The topic belongs to this convention but breaks its rules.
        """
        ...
