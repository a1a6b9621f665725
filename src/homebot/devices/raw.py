"""Messages of devices as they are on the wire, in and out."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.errors import WireError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.fields import UInt8
from homebot.messages.message import Message

__all__ = ["RawCommand", "RawMessage"]


class RawMessage(Message):
    """A raw message of a device, as received.

    Attributes:
        gateway: The name of the gateway.
        key: The gateway's key of the device.
        address: The address on which it was published (MQTT: the topic).
        payload: The payload.
        retained: Whether it was a retained message.
        received_at: The time at which it was received.
    """

    gateway: str
    key: str
    address: str
    payload: bytes
    retained: bool
    received_at: Time

    def text(self) -> str:
        """Return the payload as text.

        Raises:
            WireError: It is not UTF-8; the message names the address.
        """
        try:
            return self.payload.decode()
        except UnicodeDecodeError as exc:
            raise WireError(f"the payload on {self.address} is not text", self.payload) from exc


class RawCommand(Message):
    """A payload for a device.

    Attributes:
        address: Where the device listens (MQTT: the topic).
        payload: The text to send, as UTF-8.
        qos: MQTT quality of service, 0 to 2.
        retain: Whether the broker shall keep it for whoever comes later.
    """

    address: str
    payload: str
    qos: Annotated[UInt8, Field(le=2)] = 1
    retain: bool = False
