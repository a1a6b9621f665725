"""Report of a device: the values of its capabilities."""

from __future__ import annotations

from typing import ClassVar

from homebot.devices.value import Value
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["REACHABLE", "Reading", "Report"]

REACHABLE = "reachable"
"""Capability of a whole device (part ``""``): whether it can be reached, as its convention says."""


class Reading(Message):
    """One value of one part.

    Attributes:
        part: Which part; see :class:`homebot.devices.Part`.
        capability: Which capability.
        value: Its value in the vocabulary's unit.
    """

    part: str
    capability: str
    value: Value


class Report(Message):
    """All that one message of a device told.

    Attributes:
        gateway: The gateway that heard it.
        key: What that gateway calls the device.
        readings: What was said, in the order of the parts.
        address: Where it was said (MQTT: the topic); empty for what the gateway concluded by itself.
        stream: Key and address in one. The newest report of each is kept for late joiners, so that together they are
            all that the device told. Events are told in reports of their own, each in a stream of its own that nobody
            keeps: they happened once.
        retained: Whether the broker had kept it from before: what was, not what is.
        received_at: When.
        heard_at: When, in seconds of the monotonic clock, which nobody sets; 0 where the gateway does not say.
    """

    key_field: ClassVar[str | None] = "stream"

    gateway: str
    key: str
    readings: tuple[Reading, ...]
    address: str = ""
    stream: str = ""
    retained: bool
    received_at: Time
    heard_at: float = 0.0
