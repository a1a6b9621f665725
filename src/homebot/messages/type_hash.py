"""Type hashes of ROS 2 (RIHS01), with which two programs check that they use the same interface. Pure.

Source: ROS 2 REP 2016, "Type description and type hash"; rosidl, ``type_description_interfaces/msg/FieldType`` for the
numbers of types.
"""

import hashlib
import json
from collections.abc import Iterable
from typing import Any, Final, TypeAlias

from homebot.messages.action import ActionType
from homebot.messages.definition import FieldDefinition, fields_of, nested_types
from homebot.messages.interfaces import find_message
from homebot.messages.message import Message, ServiceType

_Field: TypeAlias = "dict[str, Any]"

_NESTED: Final = 1
_BOUNDED_TEXTS: Final = {"string": 21, "wstring": 22}
_FIXED_ARRAY, _BOUNDED_ARRAY, _ARRAY = 48, 96, 144
_PRIMITIVES: Final = {
    "int8": 2,
    "uint8": 3,
    "char": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
_EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"


def type_hash(interface: type[Message] | ServiceType[Any, Any] | ActionType[Any, Any, Any]) -> str:
    """Return the RIHS01 hash of a message, a service or an action."""
    types: dict[str, list[_Field]] = {}
    if isinstance(interface, ServiceType):
        _add_service(types, interface)
    elif isinstance(interface, ActionType):
        _add_action(types, interface)
    else:
        _add_message(types, interface, interface.ros_type)
    described = {name: {"type_name": name, "fields": fields} for name, fields in sorted(types.items())}
    own = described.pop(interface.ros_type)
    description = {"type_description": own, "referenced_type_descriptions": [*described.values()]}
    return f"RIHS01_{hashlib.sha256(json.dumps(description).encode()).hexdigest()}"


def _add_message(types: dict[str, list[_Field]], message: type[Message], name: str) -> None:
    types[name] = _describe(fields_of(message))
    for nested in nested_types(message):
        types[nested.ros_type] = _describe(fields_of(nested))


def _add_service(types: dict[str, list[_Field]], service: ServiceType[Any, Any]) -> None:
    sides = {"request": service.Request, "response": service.Response}
    names = {side: f"{service.ros_type}_{side.capitalize()}" for side in sides}
    for side, message in sides.items():
        _add_message(types, message, names[side])
    _add_message(types, find_message(_EVENT_INFO), _EVENT_INFO)
    event = f"{service.ros_type}_Event"
    kept = (FieldDefinition(side, name, is_array=True, bound=1) for side, name in names.items())
    types[event] = _describe((FieldDefinition("info", _EVENT_INFO), *kept))
    members = {f"{side}_message": name for side, name in names.items()} | {"event_message": event}
    types[service.ros_type] = _describe(FieldDefinition(name, ros_type) for name, ros_type in members.items())


def _add_action(types: dict[str, list[_Field]], action: ActionType[Any, Any, Any]) -> None:
    parts = {"Goal": action.Goal, "Result": action.Result, "Feedback": action.Feedback}
    for part, message in parts.items():
        _add_message(types, message, f"{action.ros_type}_{part}")
    for service in (action.SendGoal, action.GetResult):
        _add_service(types, service)
    _add_message(types, action.FeedbackMessage, action.FeedbackMessage.ros_type)
    members = {part.lower(): f"{action.ros_type}_{part}" for part in parts} | {
        "send_goal_service": action.SendGoal.ros_type,
        "get_result_service": action.GetResult.ros_type,
        "feedback_message": action.FeedbackMessage.ros_type,
    }
    types[action.ros_type] = _describe(FieldDefinition(name, ros_type) for name, ros_type in members.items())


def _describe(fields: Iterable[FieldDefinition]) -> list[_Field]:
    # IDL has no empty structures, so ROS 2 gives them a member.
    members = tuple(fields) or (FieldDefinition("structure_needs_at_least_one_member", "uint8"),)
    return [{"name": field.name, "type": _field_type(field)} for field in members]


def _field_type(field: FieldDefinition) -> dict[str, object]:
    is_nested = field.ros_type not in _PRIMITIVES
    number = _NESTED if is_nested else (_PRIMITIVES if field.longest is None else _BOUNDED_TEXTS)[field.ros_type]
    if field.is_array:
        number += _FIXED_ARRAY if field.size is not None else _ARRAY if field.bound is None else _BOUNDED_ARRAY
    return {
        "type_id": number,
        "capacity": field.size or field.bound or 0,
        "string_capacity": field.longest or 0,
        "nested_type_name": field.ros_type if is_nested else "",
    }
