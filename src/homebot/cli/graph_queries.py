"""Requests of the command line to ``/rosapi``: the entities of the graph, and the fields of its messages."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypedDict, cast

from homebot.cli.door_client import DoorClient
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.bridges.rosapi.endpoints import EndpointDetails

__all__ = [
    "MessageTypeRecord",
    "Schema",
    "entities",
    "is_hidden",
    "message_schema",
    "no_such_topic",
    "not_found",
    "not_yet",
    "response_schema",
    "topic_type",
]


def entities(door: DoorClient, *, kind: str = "", name: str = "", node: str = "") -> list[EndpointDetails]:
    """Return the entities of the graph, sorted by name; an empty text means any."""
    found = JsonMessage(door.call("/rosapi/endpoints", {"kind": kind, "name": name, "node": node}))
    return cast("list[EndpointDetails]", found.endpoints)


def is_hidden(entity: EndpointDetails) -> bool:
    """Return whether *entity* is shown only on request."""
    return "/_" in entity.name


def topic_type(door: DoorClient, topic: str) -> str:
    """Return the type of *topic*; empty if there is no such topic."""
    return str(door.call("/rosapi/topic_type", {"topic": topic})["type"])


def no_such_topic(door: DoorClient, topic: str) -> PeerError:
    """Return the error that there is no *topic*; its message names similar ones."""
    return not_found("topic", topic, _topics(door))


def not_yet(door: DoorClient, topic: str) -> str:
    """Return the line that says that the missing *topic* is awaited, and names similar ones."""
    similar = did_you_mean(topic, _topics(door), "", cutoff=0.7)
    return f"homebot: no topic {topic} yet; waiting, Ctrl-C stops" + (f" ({similar})" if similar else "")


def not_found(kind: str, name: str, known: Iterable[str]) -> PeerError:
    """Return the error that there is no *kind* called *name*; its message names similar ones of the *known*."""
    return PeerError(f"there is no {kind} {name}; {did_you_mean(name, known, f'`homebot {kind} list` lists all')}")


class MessageTypeRecord(TypedDict):
    """``rosapi_msgs/msg/TypeDef`` in JSON."""

    type: str
    fieldnames: list[str]
    fieldtypes: list[str]
    fieldarraylen: list[int]


class Schema:
    """A message type and the types in it, from rosapi."""

    def __init__(self, typedefs: list[MessageTypeRecord]) -> None:
        self._types = {one["type"]: _fields(one) for one in typedefs}
        self._root = typedefs[0]["type"] if typedefs else ""

    def readable(self, message: dict[str, object]) -> dict[str, object]:
        """Return *message* with its base64-encoded bytes as text if possible, else as a list."""
        return self._message(message, self._root)

    def _message(self, message: dict[str, object], ros_type: str) -> dict[str, object]:
        fields = self._types.get(ros_type, {})
        return {name: self._value(value, fields.get(name, "")) for name, value in message.items()}

    def _value(self, value: object, ros_type: str) -> object:
        if ros_type == "uint8[]" and isinstance(value, str):
            return _readable_bytes(value)
        if isinstance(value, list):
            return [self._value(item, ros_type.removesuffix("[]")) for item in value]
        return self._message(value, ros_type.removesuffix("[]")) if isinstance(value, dict) else value


def message_schema(door: DoorClient, ros_type: str) -> Schema:
    """Request the schema of the message type *ros_type*."""
    return _schema(door, "/rosapi/message_details", ros_type)


def response_schema(door: DoorClient, ros_type: str) -> Schema:
    """Request the schema of the response of the service type *ros_type*."""
    return _schema(door, "/rosapi/service_response_details", ros_type)


def _schema(door: DoorClient, service: str, ros_type: str) -> Schema:
    return Schema(cast("list[MessageTypeRecord]", door.call(service, {"type": ros_type})["typedefs"]))


def _fields(typedef: MessageTypeRecord) -> dict[str, str]:
    """Return the type of each field by name; array types end in ``[]``."""
    kinds = (typedef["fieldnames"], typedef["fieldtypes"], typedef["fieldarraylen"])
    return {name: kind if length < 0 else f"{kind}[]" for name, kind, length in zip(*kinds, strict=True)}


def _topics(door: DoorClient) -> list[str]:
    return [one.name for one in entities(door) if one.kind in {"publisher", "subscription"}]


def _readable_bytes(text: str) -> str | list[int]:
    try:
        value = base64.b64decode(text, validate=True)
    except binascii.Error:
        return text
    try:
        return value.decode()
    except UnicodeDecodeError:
        return list(value)
