"""Received message of an application, as a value."""

from __future__ import annotations

from typing import Final, NamedTuple

__all__ = ["NO_PROPERTIES", "MessageProperties", "MqttMessage"]


class MessageProperties(NamedTuple):
    """The properties an application may put on a message; MQTT 3.1.1 carries none of them.

    Attributes:
        payload_is_text: The sender declares the payload to be UTF-8 text; unchecked.
        expiry: Remaining life time of the message in whole seconds, 0 to 4294967295; None is without end.
        content_type: Type of the payload, usually a MIME type; None if not given.
        response_topic: Topic that an answer is wanted on; None if none is wanted.
        correlation_data: Token that the answer has to repeat; None if none was sent.
        user: Name and value pairs in the order of the sender; names may repeat.

    Source: MQTT Version 5.0, section 3.3.2.3.
    """

    payload_is_text: bool = False
    expiry: int | None = None
    content_type: str | None = None
    response_topic: str | None = None
    correlation_data: bytes | None = None
    user: tuple[tuple[str, str], ...] = ()


NO_PROPERTIES: Final = MessageProperties()
"""The properties of a message without any; shared, so that plain messages cost nothing."""


class MqttMessage(NamedTuple):
    """One received message.

    Attributes:
        topic: Topic name, without wildcards and never empty.
        payload: The bytes as they came; may be empty.
        qos: Delivery level of this delivery: 0, 1 or 2.
        retain: True if the broker sent it from its store, False if it is live
            (or as published, where the subscription asked for that).
        properties: MQTT 5 properties.
        receipt: Receipt for the acknowledgement by the delivering client; 0 for none.
            No part of the message: two messages with different receipts are equal.
    """

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False
    properties: MessageProperties = NO_PROPERTIES
    receipt: int = 0

    def __eq__(self, other: object) -> bool:
        """Return whether *other* has the same content, ignoring receipts."""
        return self[:5] == other[:5] if isinstance(other, MqttMessage) else NotImplemented

    def __ne__(self, other: object) -> bool:
        """Return whether *other* says anything else."""
        return not self == other

    def __hash__(self) -> int:
        return hash(self[:5])

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in zip(self._fields[:5], self, strict=False))
        return f"MqttMessage({fields})"
