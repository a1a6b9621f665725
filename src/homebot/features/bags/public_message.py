"""Messages without the secrets that devices and programs may send in raw payloads. Pure."""

from collections.abc import Mapping
from typing import Any, Final

from homebot.devices import RawCommand, RawMessage
from homebot.features.bags.bag_topic import BagMessage
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.message import Message
from homebot.recording.secrets import without_secrets

_RAW: Final[Mapping[str, type[Message]]] = {
    message_type.ros_type: message_type for message_type in (RawMessage, RawCommand)
}


def without_raw_secrets(message: BagMessage) -> BagMessage:
    """Return *message*; in the payload of a raw one, secrets are hidden as in recordings."""
    message_type = _RAW.get(message.topic.ros_type)
    if message_type is None:
        return message
    raw: Any = message_from_cdr(message_type, message.data)
    payload: bytes | str = raw.payload
    cleaned = without_secrets(payload.encode() if isinstance(payload, str) else payload)
    update = {"payload": cleaned.decode() if isinstance(payload, str) else cleaned}
    return message._replace(data=message_to_cdr(raw.model_copy(update=update)))
