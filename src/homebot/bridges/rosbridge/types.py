"""Python classes by ROS type name, and messages as clients write them.

``std_msgs/String`` and ``std_msgs/msg/String`` are both accepted, and so is ROS 1's spelling of time (``secs``,
``nsecs``).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from homebot import devices
from homebot.bridges.rosbridge.partial_messages import completed
from homebot.errors import PeerError, TypeMismatchError
from homebot.graph import Graph
from homebot.messages.builtin_interfaces import Duration, Time
from homebot.messages.definition import FieldDefinition, fields_of, nested_types
from homebot.messages.json import message_from_json
from homebot.messages.message import Message, ServiceType

__all__ = [
    "find_message_type",
    "find_service_type",
    "message_from_client",
    "message_type_of_topic",
    "partial_message_from_client",
    "same_type",
    "service_type_of",
]


@lru_cache
def _standard_messages() -> dict[tuple[str, str], type[Message]]:
    """Return the types that need not be in use, by package and name; loaded when somebody asks for a type by name."""
    from homebot.messages import rcl_interfaces, std_msgs  # noqa: PLC0415 - as above

    known: tuple[type[Message], ...] = (
        Duration,
        Time,
        devices.Device,
        devices.DeviceChange,
        devices.Endpoint,
        devices.KeyValue,
        devices.RawCommand,
        devices.RawMessage,
        devices.Sighting,
        rcl_interfaces.Log,
        rcl_interfaces.Parameter,
        rcl_interfaces.ParameterEvent,
        rcl_interfaces.ParameterValue,
        std_msgs.Bool,
        std_msgs.Empty,
        std_msgs.Float32,
        std_msgs.Float64,
        std_msgs.Int32,
        std_msgs.Int64,
        std_msgs.String,
        std_msgs.UInt8,
    )
    return {_parts(one.ros_type): one for one in known}


def _standard_services() -> tuple[ServiceType[Any, Any], ...]:
    from homebot.messages import std_srvs  # noqa: PLC0415 - as above

    return (
        devices.FindDevices,
        devices.GetIndexData,
        devices.SubscribeToTopic,
        std_srvs.SetBool,
        std_srvs.Trigger,
    )


_LONGEST_TYPE = 100


def same_type(first: str, second: str) -> bool:
    """Return whether two ROS type names mean one type, however they are spelled."""
    return _parts(first) == _parts(second)


def message_type_of_topic(graph: Graph, topic: str, ros_type: str) -> type[Message]:
    """Return what the topic with the full name *topic* carries, or would carry.

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
    """Return the message type called *ros_type*, from the standard ones and from those in use on *graph*.

    Raises:
        PeerError: It is unknown; the message names what is similar.
    """
    wanted = _parts(ros_type)
    if (standard := _standard_messages().get(wanted)) is not None:
        return standard
    in_use = graph.get_message_types()
    for known in (*in_use, *(inner for outer in in_use for inner in nested_types(outer))):
        if _parts(known.ros_type) == wanted:
            return known
    raise _unknown("message", ros_type, [known.ros_type for known in _standard_messages().values()])


def find_service_type(graph: Graph, ros_type: str) -> ServiceType[Any, Any]:
    """Return the service type called *ros_type*, from the standard ones and from those in use on *graph*.

    Raises:
        PeerError: It is unknown; the message names what is similar.
    """
    wanted = _parts(ros_type)
    for known in (*_standard_services(), *graph.get_service_types()):
        if _parts(known.ros_type) == wanted:
            return known
    raise _unknown("service", ros_type, [known.ros_type for known in _standard_services()])


def _parts(ros_type: str) -> tuple[str, str]:
    package, _, rest = ros_type.partition("/")
    return package, rest.removeprefix("msg/").removeprefix("srv/")


def _unknown(kind: str, ros_type: str, known: list[str]) -> PeerError:
    from difflib import get_close_matches  # noqa: PLC0415 - as in homebot.similar

    similar = get_close_matches(ros_type[:_LONGEST_TYPE], known, n=3, cutoff=0.5)  # it takes the square of the length
    hint = f"; similar: {', '.join(similar)}" if similar else ""
    return PeerError(f"unknown {kind} type {ros_type[:_LONGEST_TYPE]!r}{hint}")


_ROS2_NAMES = {"secs": "sec", "nsecs": "nanosec"}


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
    whole, missing = completed(message_type, _in_ros2(message_type, value))
    return message_from_json(message_type, whole), missing


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
