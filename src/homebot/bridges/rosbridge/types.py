"""Python classes by ROS type name, and messages as clients write them.

``std_msgs/String`` and ``std_msgs/msg/String`` are both accepted, and so is ROS 1's spelling of time (``secs``,
``nsecs``). The ``seq`` of a ROS 1 header is ignored, as ROS 2 has none. Missing headers, headers without a stamp, and
times given as the text ``now`` get the current time.

An unknown type is a PeerError, a type other than the one in use a TypeMismatchError.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, section 3.2.3; for ``now`` its ``message_conversion.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, TypeVar

from homebot.devices.access_messages import DefineTypeRequest, DefineTypeResponse
from homebot.errors import PeerError, TypeMismatchError, UsageError
from homebot.feature import all_features
from homebot.graph import Graph
from homebot.messages.builtin_interfaces import Duration, Time
from homebot.messages.definition import FieldDefinition, fields_by_name, nested_types, zero_of
from homebot.messages.json import message_from_json
from homebot.messages.message import Message, ServiceType

if TYPE_CHECKING:
    from homebot.messages import Interfaces
    from homebot.messages.action import ActionType

InterfaceT = TypeVar("InterfaceT", type[Message], ServiceType[Any, Any], "ActionType[Any, Any, Any]")

_CORE_MODULES: Final = (
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
"""The modules of the core with messages and services for clients of the rosbridge server."""


def own_modules() -> tuple[str, ...]:
    """Return the modules with messages and services for clients of the rosbridge server, those of features included."""
    return (*_CORE_MODULES, *(module for feature in all_features() for module in feature.messages))


def same_type(first: str, second: str) -> bool:
    """Return whether two ROS type names mean the same type, whatever their spelling."""
    return _parts(first) == _parts(second)


def message_type_of_topic(graph: Graph, topic: str, ros_type: str) -> type[Message]:
    """Return the current or future type of the topic with the full name *topic*.

    Args:
        ros_type: The type that the client expects; may be empty if the topic exists.
    """
    carried = _check(f"topic {topic} carries", graph.get_message_type(topic), ros_type)
    if carried is None and not ros_type:
        raise PeerError(f"there is no topic {topic} yet, so its type must be given")
    return carried or find_message_type(graph, ros_type)


def service_type_of(graph: Graph, service: str, ros_type: str) -> ServiceType[Any, Any]:
    """Return the type that a new server of *service* has."""
    used = _check(f"service {service} is a", graph.get_service_type(service), ros_type)
    return used or find_service_type(graph, ros_type)


def action_type_of(graph: Graph, action: str, ros_type: str) -> ActionType[Any, Any, Any]:
    """Return the type that *action* has, or that a new server of it has."""
    used = _check(f"action {action} is a", graph.get_action_type(action), ros_type)
    return used or find_action_type(graph, ros_type)


def find_message_type(graph: Graph, ros_type: str) -> type[Message]:
    """Return the message type called *ros_type*: one in use on topics of *graph*, or by its definition."""
    part: type[Message] | None = _part_of_action(graph, ros_type, "FeedbackMessage")
    if part is not None:
        return part
    in_use = graph.get_message_types()  # first, as an app may have its own class for a standard type
    inside = (inner for outer in in_use for inner in nested_types(outer))
    return _find(graph, ros_type, chain(in_use, inside), lambda interfaces: interfaces.find_message(ros_type))


def find_service_type(graph: Graph, ros_type: str) -> ServiceType[Any, Any]:
    """Return the service type called *ros_type*; see :func:`find_message_type`."""
    part: ServiceType[Any, Any] | None = _part_of_action(graph, ros_type, "SendGoal", "GetResult")
    if part is not None:
        return part
    known = graph.get_service_types(partial(same_type, ros_type))  # another would be loaded for nothing
    return _find(graph, ros_type, known, lambda interfaces: interfaces.find_service(ros_type))


def find_action_type(graph: Graph, ros_type: str) -> ActionType[Any, Any, Any]:
    """Return the action type called *ros_type*; see :func:`find_message_type`."""
    named = (action for action in graph.actions() if same_type(action.ros_type, ros_type))
    known = (action_type for action in named if (action_type := graph.get_action_type(action.name)) is not None)
    return _find(graph, ros_type, known, lambda interfaces: interfaces.find_action(ros_type))


def _part_of_action(graph: Graph, ros_type: str, *parts: str) -> Any:
    """Return the type called *ros_type* if it is one of the *parts* of an action, such as ``pkg/action/X_SendGoal``."""
    action, _, part = ros_type.rpartition("_")
    is_part = part in parts and "/action/" in action
    return getattr(find_action_type(graph, action), part) if is_part else None


def define_type(graph: Graph, request: DefineTypeRequest) -> DefineTypeResponse:
    """Define a type for the clients of *graph*; the answer has the reason of a failure."""
    from homebot.messages.type_hash import type_hash  # noqa: PLC0415 - few clients define types

    try:
        defined = interfaces_of(graph).define(request.type, request.definition, request.issuer)
    except UsageError as exc:
        return DefineTypeResponse(success=False, message=str(exc))
    return DefineTypeResponse(success=True, type_hash=type_hash(defined))


def _check(subject: str, used: InterfaceT | None, ros_type: str) -> InterfaceT | None:
    if used is not None and ros_type and not same_type(used.ros_type, ros_type):
        article = "a " if subject.endswith(" a") else ""
        raise TypeMismatchError(f"{subject} {used.ros_type}, not {article}{ros_type}")
    return used


def _find(
    graph: Graph, ros_type: str, known: Iterable[InterfaceT], define: Callable[[Interfaces], InterfaceT]
) -> InterfaceT:
    known_type = next((candidate for candidate in known if same_type(candidate.ros_type, ros_type)), None)
    if known_type is not None:
        return known_type
    try:
        return define(interfaces_of(graph))
    except UsageError as exc:  # the client's mistake
        raise PeerError(str(exc)) from exc


def interfaces_of(graph: Graph) -> Interfaces:
    """Return the interfaces of *graph*, including homebot's own."""
    graph.interfaces.add_modules("homebot", own_modules())
    return graph.interfaces


def _parts(ros_type: str) -> tuple[str, str]:
    package, _, rest = ros_type.partition("/")
    return package, rest.removeprefix("msg/").removeprefix("srv/").removeprefix("action/")


_TIME_NAMES = {"secs": "sec", "nsecs": "nanosec"}
_ROS2_NAMES: dict[type[Message], dict[str, str]] = {Time: _TIME_NAMES, Duration: _TIME_NAMES}
_HEADER = "std_msgs/msg/Header"
_ROS1_COUNTER = "seq"
_NOW = "now"


def message_from_client(message_type: type[Message], value: Mapping[str, object]) -> Message:
    """Return the message given by the JSON object *value*.

    Raises:
        TypeMismatchError: A field is missing, unknown, or of another type; the message names it and its value.
    """
    try:
        return message_from_json(message_type, value)
    except TypeMismatchError:  # as nearly none is
        return message_from_json(message_type, _in_ros2(message_type, value, None))


def partial_message_from_client(
    message_type: type[Message], value: Mapping[str, object], now: float
) -> tuple[Message, tuple[str, ...]]:
    """Return the message given in part by the JSON object *value*, and the names of its missing fields.

    Names of nested fields have dots. Headers and fields with a default are not missing. A text that must be one of an
    enumeration stays missing.

    Args:
        now: Seconds since the Unix epoch.

    Raises:
        TypeMismatchError: A field is unknown, of another type, or cannot be zero; the message names it and its value.
    """
    missing: dict[str, None] = {}
    stamp = Time.from_seconds(now).model_dump()
    whole = _in_ros2(message_type, value, missing, stamp=stamp)
    return message_from_json(message_type, whole), tuple(missing)


def request_from_client(message_type: type[Message], value: Mapping[str, object], now: float) -> Message:
    """Return the part of a service or action given by *value*; missing fields are zero or empty, as in ROS.

    Messages of homebot's own types must be complete, as they may be commands.
    """
    if message_type.ros_type.startswith("homebot/"):
        return message_from_client(message_type, value)
    return partial_message_from_client(message_type, value, now)[0]


def _in_ros2(
    message_type: type[Message],
    value: Mapping[str, object],
    missing: dict[str, None] | None,
    path: str = "",
    stamp: object = None,
) -> dict[str, object]:
    """Return *value* with ROS 2's names, and completed if *missing* is given, which receives the missing names.

    Headers without a stamp, and times that are ``now``, get *stamp*, unless that is None.
    """
    fields = fields_by_name(message_type)
    names = _ROS2_NAMES.get(message_type, {})
    whole = {names.get(name, name): item for name, item in value.items()}
    if message_type.ros_type == _HEADER:
        _complete_header(whole, fields, stamp)
    for name, field in fields.items():
        if name in whole:
            whole[name] = _element(field, whole[name], missing, f"{path}{name}.", stamp)
        elif missing is not None and message_type.model_fields[name].is_required() and field.choices is None:
            if field.ros_type == _HEADER and not path:
                whole[name] = _zero(field, stamp)
            else:
                whole[name] = _zero(field, None)
                missing[f"{path}{name}"] = None
    return whole


def _complete_header(whole: dict[str, object], fields: Container[str], stamp: object) -> None:
    if _ROS1_COUNTER in fields:
        return
    whole.pop(_ROS1_COUNTER, None)
    if stamp is not None:
        whole.setdefault("stamp", stamp)


def _zero(field: FieldDefinition, stamp: object) -> object:
    """Return the zero value of *field* in JSON; headers in it get *stamp*, unless that is None."""
    return zero_of(field) if field.message is None or field.is_array else _element(field, {}, {}, stamp=stamp)


def _element(
    field: FieldDefinition, value: object, missing: dict[str, None] | None, path: str = "", stamp: object = None
) -> object:
    if field.message is None:
        return value
    if isinstance(value, list) and field.is_array:
        return [_element(field, item, missing, path, stamp) for item in value]
    if value == _NOW and field.message is Time and stamp is not None:
        return stamp
    return _in_ros2(field.message, value, missing, path, stamp) if isinstance(value, dict) else value
