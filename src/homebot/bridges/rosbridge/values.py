"""Messages as clients write them, ROS 1's spelling of time (``secs``, ``nsecs``) included."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.messages.builtin_interfaces import Duration, Time
from homebot.messages.definition import FieldDefinition, fields_of
from homebot.messages.json import message_from_json
from homebot.messages.message import Message

__all__ = ["message_from_client"]

_ROS2_NAMES = {"secs": "sec", "nsecs": "nanosec"}


def message_from_client(message_type: type[Message], value: Mapping[str, object]) -> Message:
    """Return the message that the JSON object *value* spells.

    Raises:
        TypeMismatchError: A field is missing, unknown, or of another type; the message names it and its value.
    """
    return message_from_json(message_type, _in_ros2(message_type, value))


def _in_ros2(message_type: type[Message], value: Mapping[str, object]) -> dict[str, object]:
    if message_type in {Time, Duration}:
        return {_ROS2_NAMES.get(name, name): item for name, item in value.items()}
    fields = {field.name: field for field in fields_of(message_type)}
    return {name: _element(fields[name], item) if name in fields else item for name, item in value.items()}


def _element(field: FieldDefinition, value: object) -> object:
    if field.message is None:
        return value
    if isinstance(value, list):
        return [_element(field, item) for item in value]
    return _in_ros2(field.message, value) if isinstance(value, dict) else value
