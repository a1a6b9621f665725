"""A received message, as a value."""

from typing import NamedTuple

from homebot.mqtt.packets import NO_PROPERTIES, Properties


class MqttMessage(NamedTuple):
    """One received message.

    Attributes:
        topic: Topic name, without wildcards and never empty.
        qos: Delivery level of this delivery: 0, 1 or 2.
        retain: True if the broker sent it from its store, False if it is live
            (or as published, if the subscription asked for that).
        properties: MQTT 5 only.
        receipt: Receipt for the acknowledgement by the delivering client; 0 for none. Not part of the message: messages
            that differ only in it are equal.
    """

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False
    properties: Properties = NO_PROPERTIES
    receipt: int = 0

    def __eq__(self, other: object) -> bool:
        """Return whether *other* has the same content, ignoring receipts."""
        return self[:5] == other[:5] if isinstance(other, MqttMessage) else NotImplemented

    def __ne__(self, other: object) -> bool:
        """Return whether *other* has different content."""
        return not self == other

    def __hash__(self) -> int:
        return hash(self[:5])

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in zip(self._fields[:5], self, strict=False))
        return f"MqttMessage({fields})"
