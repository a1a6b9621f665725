"""Python classes by ROS type name, and messages as clients write them.

``std_msgs/String`` and ``std_msgs/msg/String`` are both accepted, and so is ROS 1's spelling of time (``secs``,
``nsecs``). A value of a device may be given
as it is in JSON (``true``, ``40``). The ``seq`` of a ROS 1 header, which counts messages, is left out: ROS 2 has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from homebot.devices.access_messages import DefineTypeRequest, DefineTypeResponse
from homebot.devices.value import Value
from homebot.errors import PeerError, TypeMismatchError, UsageError
from homebot.graph import Graph
from homebot.messages.builtin_interfaces import Duration, Time
from homebot.messages.definition import FieldDefinition, fields_of, nested_types
from homebot.messages.json import message_from_json
from homebot.messages.message import Message, ServiceType

if TYPE_CHECKING:
    from homebot.messages import Interfaces
    from homebot.messages.action import ActionType

__all__ = [
    "OWN_MODULES",
    "action_type_of",
    "define_type",
    "find_action_type",
    "find_message_type",
    "find_service_type",
    "message_from_client",
    "message_type_of_topic",
    "partial_message_from_client",
    "same_type",
    "service_type_of",
]


OWN_MODULES: Final = (
    "homebot.devices.access_messages",
    "homebot.devices.action_messages",
    "homebot.devices.device",
    "homebot.devices.gateway_messages",
    "homebot.devices.command_messages",
    "homebot.devices.lease_messages",
    "homebot.devices.places_messages",
    "homebot.devices.robot_messages",
    "homebot.devices.services",
)
"""The modules with messages and services that clients of the door use."""


def same_type(first: str, second: str) -> bool:
    """Return whether two ROS type names mean one type, however they are spelled."""
    return _parts(first) == _parts(second)


def message_type_of_topic(graph: Graph, topic: str, ros_type: str) -> type[Message]:
    """Return the current or future type of the topic with the full name *topic*.

    Args:
        graph: The graph.
        topic: Full name.
        ros_type: The type that the client expects; may be empty where the topic exists.

    Raises:
        TypeMismatchError: The topic carries another type.
        PeerError: There is no such topic and the type is empty or unknown.
    """
    carried = graph.get_message_type(topic)
    if carried is None:
        if not ros_type:
            raise PeerError(f"there is no topic {topic} yet, so its type must be given")
        return find_message_type(graph, ros_type)
    if ros_type and not same_type(carried.ros_type, ros_type):
        raise TypeMismatchError(f"topic {topic} carries {carried.ros_type}, not {ros_type}")
    return carried


def service_type_of(graph: Graph, service: str, ros_type: str) -> ServiceType[Any, Any]:
    """Return the type that a new server of *service* has.

    Raises:
        TypeMismatchError: The service is of another type.
        PeerError: The type is unknown.
    """
    used = graph.get_service_type(service)
    if used is None:
        return find_service_type(graph, ros_type)
    if not same_type(used.ros_type, ros_type):
        raise TypeMismatchError(f"service {service} is a {used.ros_type}, not a {ros_type}")
    return used


def find_message_type(graph: Graph, ros_type: str) -> type[Message]:
    """Return the message type called *ros_type*, from those that topics of *graph* carry, or by its definition.

    Raises:
        PeerError: It is unknown; the message suggests similar names.
    """
    wanted = _parts(ros_type)
    in_use = graph.get_message_types()  # first, as an app may have a class of its own for a standard type
    inside = (inner for outer in in_use for inner in nested_types(outer))
    found = next((known for known in chain(in_use, inside) if _parts(known.ros_type) == wanted), None)
    if found is None:
        with _refusing():
            found = _interfaces(graph).find_message(ros_type)
    return found


def find_service_type(graph: Graph, ros_type: str) -> ServiceType[Any, Any]:
    """Return the service type called *ros_type*, as :func:`find_message_type` does."""
    wanted = _parts(ros_type)
    found = next((known for known in graph.get_service_types() if _parts(known.ros_type) == wanted), None)
    if found is None:
        with _refusing():
            found = _interfaces(graph).find_service(ros_type)
    return found


def define_type(graph: Graph, request: DefineTypeRequest) -> DefineTypeResponse:
    """Define a type for the clients of *graph*; the answer says why it cannot be."""
    from homebot.messages.type_hash import type_hash  # noqa: PLC0415 - few clients define types

    try:
        defined = _interfaces(graph).define(request.type, request.definition)
    except UsageError as exc:
        return DefineTypeResponse(success=False, message=str(exc))
    return DefineTypeResponse(success=True, type_hash=type_hash(defined))


@contextmanager
def _refusing() -> Iterator[None]:
    try:
        yield
    except UsageError as exc:  # the client's mistake
        raise PeerError(str(exc)) from exc


def _interfaces(graph: Graph) -> Interfaces:
    """Return the interfaces of *graph* with homebot's own among them."""
    graph.interfaces.add_modules("homebot", OWN_MODULES)
    return graph.interfaces


def action_type_of(graph: Graph, action: str, ros_type: str) -> ActionType[Any, Any, Any]:
    """Return the type that a new server of *action* has.

    Raises:
        TypeMismatchError: The action is of another type.
        PeerError: The type is unknown.
    """
    used = graph.get_action_type(action)
    if used is None:
        return find_action_type(graph, ros_type)
    if not same_type(used.ros_type, ros_type):
        raise TypeMismatchError(f"action {action} is a {used.ros_type}, not a {ros_type}")
    return used


def find_action_type(graph: Graph, ros_type: str) -> ActionType[Any, Any, Any]:
    """Return the action type called *ros_type*, from those of actions on *graph*, or by its definition.

    Raises:
        PeerError: It is unknown; the message suggests similar names.
    """
    wanted = _parts(ros_type)
    for action in graph.actions():
        known = graph.get_action_type(action.name)
        if known is not None and _parts(known.ros_type) == wanted:
            return known
    with _refusing():
        return _interfaces(graph).find_action(ros_type)


def _parts(ros_type: str) -> tuple[str, str]:
    package, _, rest = ros_type.partition("/")
    return package, rest.removeprefix("msg/").removeprefix("srv/").removeprefix("action/")


_ROS2_NAMES = {"secs": "sec", "nsecs": "nanosec"}
_HEADER = "std_msgs/msg/Header"
_ROS1_COUNTER = "seq"


def message_from_client(message_type: type[Message], value: Mapping[str, object]) -> Message:
    """Return the message that the JSON object *value* spells.

    Raises:
        TypeMismatchError: A field is missing, unknown, or of another type; the message names it and its value.
    """
    return message_from_json(message_type, _in_ros2(message_type, value))


def partial_message_from_client(
    message_type: type[Message], value: Mapping[str, object]
) -> tuple[Message, tuple[str, ...]]:
    """Return the message that the JSON object *value* spells in part, and the names of the fields that it lacks.

    Raises:
        TypeMismatchError: A field is unknown, of another type, or cannot be zero; the message names it and its value.
    """
    whole, missing = _completed(message_type, _in_ros2(message_type, value))
    return message_from_json(message_type, whole), missing


def _in_ros2(message_type: type[Message], value: Mapping[str, object]) -> dict[str, object]:
    if message_type in {Time, Duration}:
        return {_ROS2_NAMES.get(name, name): item for name, item in value.items()}
    fields = {field.name: field for field in fields_of(message_type)}
    if message_type.ros_type == _HEADER and _ROS1_COUNTER not in fields:
        value = {name: item for name, item in value.items() if name != _ROS1_COUNTER}
    return {name: _element(fields[name], item) if name in fields else item for name, item in value.items()}


def _element(field: FieldDefinition, value: object) -> object:
    if field.message is None:
        return value
    if isinstance(value, list) and field.is_array:
        return [_element(field, item) for item in value]
    if field.message is Value and not isinstance(value, dict):
        return _spelled_out(value)
    return _in_ros2(field.message, value) if isinstance(value, dict) else value


def _spelled_out(plain: object) -> object:
    """Return the fields of the :class:`Value` that a client wrote as it is in JSON, such as ``true`` or ``40``."""
    match plain:
        case None:
            return {}
        case bool():
            return {"type": 1, "flag": plain}
        case int() | float():
            return {"type": 2, "number": plain}
        case str():
            return {"type": 3, "text": plain}
        case list():
            return {"type": 4, "numbers": plain}
    return plain


_ZEROS: Final[Mapping[str, object]] = {"bool": False, "string": "", "float32": 0.0, "float64": 0.0}


def _completed(message_type: type[Message], values: Mapping[str, object]) -> tuple[dict[str, object], tuple[str, ...]]:
    """Return *values* with the fields that are missing, and their names, with dots where they are of messages inside.

    A field with a default in *message_type* is not missing. A text that has to be one of an enumeration stays missing.
    """
    whole, names = dict(values), []
    for field in fields_of(message_type):
        if field.name in whole:
            whole[field.name], inner = _completed_field(field, whole[field.name])
            names += [f"{field.name}.{name}" for name in inner]
        elif message_type.model_fields[field.name].is_required() and field.choices is None:
            whole[field.name] = _zero(field)
            names.append(field.name)
    return whole, tuple(names)


def _completed_field(field: FieldDefinition, value: object) -> tuple[object, tuple[str, ...]]:
    if field.message is None:
        return value, ()
    if isinstance(value, Mapping):
        return _completed(field.message, value)
    if not isinstance(value, list):
        return value, ()
    parts = [_completed(field.message, one) if isinstance(one, Mapping) else (one, ()) for one in value]
    return [one for one, _ in parts], tuple(dict.fromkeys(name for _, inner in parts for name in inner))


def _zero(field: FieldDefinition) -> object:
    zero = _ZEROS.get(field.ros_type, 0) if field.message is None else _completed(field.message, {})[0]
    return [zero] * (field.size or 0) if field.is_array else zero
