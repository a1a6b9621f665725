"""What a gateway tells of the devices it hears."""

from __future__ import annotations

from typing import ClassVar, Literal

from homebot.devices.device import KeyValue
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Sighting"]


class Sighting(Message):
    """A gateway heard of a device: that it is there, that it is still there, or that it is gone.

    Attributes:
        gateway: Name of the gateway.
        key: What the gateway calls the device; one device has one key at one gateway.
        kind: ``appeared``, ``updated`` (still there, or described anew) or ``removed``.
        why: The reason, in words.
        name: What people call the device.
        service_type: What it offers.
        address: Where it speaks.
        command_address: Where it listens; empty when it takes no commands.
        metadata: Further facts.
        seen_at: When.
        expires_at: When it becomes stale unless it is seen again; the gateway alone knows its protocol's habits.
        confirmed: Whether the device itself spoke, rather than a message that the broker had kept.
    """

    key_field: ClassVar[str | None] = "key"

    gateway: str
    key: str
    kind: Literal["appeared", "updated", "removed"]
    why: str
    name: str
    service_type: str
    address: str
    command_address: str
    metadata: tuple[KeyValue, ...] = ()
    seen_at: Time
    expires_at: Time
    confirmed: bool
