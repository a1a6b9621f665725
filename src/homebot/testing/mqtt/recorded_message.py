"""A message as a test sees it, and what a test may give as a payload."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from homebot.mqtt.packets import NO_PROPERTIES, Properties

__all__ = ["Payload", "RecordedMessage", "Wanted", "encode_payload", "payload_matches"]

Payload = bytes | str | Mapping[str, object] | Sequence[object]
"""What can be published: bytes as they are, text as UTF-8, a dict or list as JSON."""

_MAX_TEXT = 200


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """A message that a client published through the broker; a will counts as its client's.

    Attributes:
        topic: Full topic name.
        payload: The content.
        qos: What it was published with.
        retain: Whether it was published to be retained.
        properties: The MQTT 5 properties.
        client_id: Who published it.
    """

    topic: str
    payload: bytes = b""
    qos: int = 0
    retain: bool = False
    properties: Properties = NO_PROPERTIES
    client_id: str = ""

    @property
    def text(self) -> str:
        """The payload as UTF-8; bytes that are none come as U+FFFD."""
        return self.payload.decode(errors="replace")

    def json(self) -> object:
        """The payload read as JSON.

        Raises:
            ValueError: It is none.
        """
        return json.loads(self.payload)

    def __str__(self) -> str:
        text = repr(self.text)
        if len(text) > _MAX_TEXT:
            text = f"{text[:_MAX_TEXT]}… ({len(self.payload)} bytes)"
        retain = ", retain" if self.retain else ""
        return f"{self.topic} {text} (QoS {self.qos}{retain}, from {self.client_id})"


Wanted = Payload | Callable[[RecordedMessage], bool] | None
"""What a test expects: None is anything, a dict or list is compared as JSON, a function decides by itself."""


def encode_payload(payload: Payload) -> bytes:
    """The bytes that *payload* stands for.

    Raises:
        TypeError: A value inside has no JSON form.
    """
    if isinstance(payload, bytes | bytearray | memoryview):
        return bytes(payload)
    if isinstance(payload, str):
        return payload.encode()
    return json.dumps(payload).encode()


def payload_matches(wanted: Wanted, message: RecordedMessage) -> bool:
    """Return whether *message* carries the wanted payload."""
    if wanted is None:
        return True
    if callable(wanted):
        return wanted(message)
    if isinstance(wanted, bytes | bytearray | memoryview | str):
        return encode_payload(wanted) == message.payload
    try:
        return bool(message.json() == json.loads(encode_payload(wanted)))
    except ValueError:  # also bytes that are no text
        return False
