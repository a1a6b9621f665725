"""What the directory knows of a device."""

from __future__ import annotations

from typing import ClassVar, Literal, TypeAlias

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Device", "DeviceChange", "Endpoint", "Freshness", "KeyValue"]

Freshness: TypeAlias = Literal["fresh", "unconfirmed", "stale"]
ChangeKind: TypeAlias = Literal["appeared", "changed", "stale", "returned", "removed"]


class KeyValue(Message):
    """One fact about a device, as its gateway heard it."""

    ros_type: ClassVar[str] = "diagnostic_msgs/msg/KeyValue"

    key: str
    value: str


class Endpoint(Message):
    """One way to reach a device.

    Attributes:
        gateway: Name of the gateway that hears the device.
        key: What that gateway calls the device.
        address: Where the device speaks, in the gateway's own terms (MQTT: the topic of its messages).
        command_address: Where the device listens; empty when it takes no commands.
    """

    gateway: str
    key: str
    address: str
    command_address: str


class Device(Message):
    """A device in the house.

    Attributes:
        id: Unique in this homebot, for example ``lights/roomlights405``.
        name: What people call it.
        service_type: What it offers, in the words it was announced with, for example ``lights``.
        endpoints: The ways to reach it, at least one.
        metadata: Further facts.
        first_seen: When it was first heard of.
        last_seen: When it was last heard of, to about a second.
        expires: When it becomes stale unless it is heard of again.
        freshness: ``fresh``: it spoke itself; ``unconfirmed``: only a message that the broker had kept speaks for it;
            ``stale``: it has been silent for too long.
    """

    id: str
    name: str
    service_type: str
    endpoints: tuple[Endpoint, ...]
    metadata: tuple[KeyValue, ...]
    first_seen: Time
    last_seen: Time
    expires: Time
    freshness: Freshness


class DeviceChange(Message):
    """Something happened to a device.

    Attributes:
        kind: ``appeared``, ``changed``, ``stale``, ``returned`` (from stale) or ``removed``.
        device: The device after the change; before it where it was removed.
        sequence: Grows with every change and never goes back; a snapshot names the last one it holds.
        why: The reason, in words.
    """

    key_field: ClassVar[str | None] = "device.id"

    kind: ChangeKind
    device: Device
    sequence: int
    why: str
