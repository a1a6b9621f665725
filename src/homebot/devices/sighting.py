"""Sighting: a gateway's message about a device."""

from __future__ import annotations

from typing import ClassVar, Literal

from homebot.devices.device import KeyValue
from homebot.devices.names import is_text_address
from homebot.devices.part import Part
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Sighting"]


class Sighting(Message):
    """A gateway heard of a device: that it is there, that it is still there, or that it is gone.

    Attributes:
        gateway: Name of the gateway.
        key: What the gateway calls the device, or one announcement of it, then beginning with its convention, for
            example ``homeassistant:light/0x17_light``: a device that is announced in several messages, or through
            several conventions, has as many keys.
        kind: ``appeared``, ``updated`` (still there, or described anew) or ``removed``.
        why: The reason, in words.
        name: What people call the device.
        service_type: What it offers, in its own word; of a device that is described, what the first part is that is
            neither setting nor diagnosis.
        address: Where it speaks. Of a device that is described, the words address of that part; see
            :mod:`homebot.devices.text.commands`.
        command_address: Where it listens; empty when it takes no commands. Of a device that is described likewise.
        metadata: Further facts, for example ``manufacturer``, ``model``, ``sw_version``, ``via_device``.
        convention: By which convention it was announced; empty where there is one only.
        native: Whether the device, or the bridge that connects it, announced itself in a convention of its own: that is
            preferred to what somebody else makes of it.
        whole_device: Whether each announcement of the convention is of a whole device: two of them are never about the
            same one, unless they name one radio address.
        identifiers: Who the device is; see :func:`homebot.devices.identity.identifiers`.
        area: The room it was said to be in.
        parts: What it offers in the words of the vocabulary; empty where only its service type is known.
        owns: Topics that the device has for itself with all that is below them, as its own place or the bridge that
            speaks for it says, rather than its announcement; nobody else may send commands there.
        announced_on: Where it was announced (MQTT: the topic); empty where it only spoke.
        seen_at: When.
        expires_at: When it becomes stale unless it is seen again; the gateway alone knows its protocol's habits.
        confirmed: Whether the device itself spoke, rather than a message that the broker had kept.
        heard_at: When, in seconds of the monotonic clock, which nobody sets; 0 where the gateway does not say.
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
    convention: str = ""
    native: bool = False
    whole_device: bool = False
    identifiers: tuple[str, ...] = ()
    area: str = ""
    parts: tuple[Part, ...] = ()
    owns: tuple[str, ...] = ()
    announced_on: str = ""
    seen_at: Time
    expires_at: Time
    confirmed: bool
    heard_at: float = 0.0

    @property
    def speaks_plainly(self) -> bool:
        """True if it says words on an address of its own, as in the thesis's layout."""
        return bool(self.address) and not is_text_address(self.address)
