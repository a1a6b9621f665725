"""The services of ``/rosapi`` as rows: type, fields of request and response as in ``rosapi_msgs``, and the answer.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Final, NamedTuple, TypeAlias

from pydantic import create_model

from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.rosapi import parameters
from homebot.bridges.rosapi.endpoints import FindEndpoints, find_endpoints
from homebot.bridges.rosapi.typedefs import TypeDef, typedefs_of
from homebot.bridges.rosbridge.types import (
    define_type,
    find_action_type,
    find_message_type,
    find_service_type,
    interfaces_of,
    same_type,
)
from homebot.devices.access_messages import DefineType
from homebot.devices.names import DEFINE_TYPE
from homebot.graph import EndpointInfo, EntityKind, Graph, Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import definition_text
from homebot.messages.message import Int32, Message, ServiceType, UInt8, UInt32
from homebot.names import is_hidden

__all__ = ["SERVICES", "RosApi", "RosApiService"]

_Fields: TypeAlias = Mapping[str, Any]
_Answer: TypeAlias = Mapping[str, object]


class RosApiService(NamedTuple):
    """One service of ``/rosapi``.

    Attributes:
        name: Its name below ``/rosapi``.
        ros_name: The name of its type in ``rosapi_msgs``.
        request: The types of the fields of the request, with the default if there is one.
        response: The types of the fields of the response.
        answer: Returns the fields of the response to a request.
    """

    name: str
    ros_name: str
    request: _Fields
    response: _Fields
    answer: Callable[[Graph, Any], _Answer]

    def serve(self, node: Node, error_log: ClientErrorLog) -> None:
        """Offer the service on *node*; log why a parameter was not set, as the libraries of clients do not read it."""
        ros_type = f"rosapi_msgs/srv/{self.ros_name}"
        response = _message_type(f"{ros_type}_Response", self.response)
        service_type = ServiceType(ros_type, _message_type(f"{ros_type}_Request", self.request), response)

        def answer(request: Message) -> Message:
            answered = self.answer(node.graph, request)
            if self.response is _DONE and not answered["successful"]:
                error_log.log(self.name, "rosapi.refused", f"{self.name} was refused: {answered['reason']}")
            return response(**answered)

        node.create_service(service_type, f"/rosapi/{self.name}", answer)


def _message_type(ros_type: str, fields: _Fields) -> type[Message]:
    definitions: dict[str, Any] = {name: one if isinstance(one, tuple) else (one, ...) for name, one in fields.items()}
    name = ros_type.rpartition("/")[2].replace("_", "")
    return create_model(name, __base__=Message, __cls_kwargs__={"ros_type": ros_type}, **definitions)


class TimeOfBothKinds(Message):
    """A point in time as ROS 2 and as ROS 1 spell it, since clients of both ask."""

    sec: Int32
    nanosec: UInt32
    secs: Int32
    nsecs: UInt32


def _topics(graph: Graph, _request: Message) -> _Answer:
    topics = _visible(graph.get_topic_names_and_types())
    return {"topics": tuple(topics), "types": tuple(topics.values())}


def _topics_with_texts(graph: Graph, _request: Message) -> _Answer:
    topics = _visible(graph.get_topic_names_and_types())
    texts = tuple(definition_text(found) for name in topics if (found := graph.get_message_type(name)))
    return {"topics": tuple(topics), "types": tuple(topics.values()), "typedefs_full_text": texts}


def _topics_of_type(graph: Graph, request: Any) -> _Answer:
    types = (known.ros_type for known in graph.get_message_types() if same_type(known.ros_type, request.type))
    return {"topics": _unique(name for one in types for name in graph.get_topics_of_type(one) if not is_hidden(name))}


def _type_of_topic(graph: Graph, request: Any) -> _Answer:
    found = graph.get_message_type(_absolute(request.topic))
    return {"type": found.ros_type if found else ""}


def _type_of_service(graph: Graph, request: Any) -> _Answer:
    found = graph.get_endpoints(kind=EntityKind.SERVICE, name=_absolute(request.service))
    return {"type": found[0].ros_type if found else ""}


def _node_of_service(graph: Graph, request: Any) -> _Answer:
    found = graph.get_endpoints(kind=EntityKind.SERVICE, name=_absolute(request.service))
    return {"node": found[0].node if found else ""}


def _node_details(graph: Graph, request: Any) -> _Answer:
    """Return the subscriptions, publications and services of a node; empty for an unknown one."""
    ends = graph.get_endpoints(node=_absolute(request.node))
    return {
        "subscribing": _unique(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
        "publishing": _unique(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
        "services": _unique(info.name for info in ends if info.kind is EntityKind.SERVICE),
    }


def _action_servers(graph: Graph, _request: Message) -> _Answer:
    return {"action_servers": tuple(action.name for action in graph.actions() if action.servers)}


def _type_of_action(graph: Graph, request: Any) -> _Answer:
    return {"type": graph.get_action_names_and_types().get(_absolute(request.action), "")}


def _details_of_action(part: str) -> Callable[[Graph, Any], _Answer]:
    """Return the function that describes the *part* of an action type: its Goal, Result or Feedback."""
    return lambda graph, request: {"typedefs": typedefs_of(getattr(find_action_type(graph, request.type), part))}


def _time(graph: Graph, _request: Message) -> _Answer:
    now = Time.from_seconds(graph.clock.now())
    return {"time": TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec)}


def _served(graph: Graph, ros_type: str) -> Iterator[EndpointInfo]:
    for known in graph.get_service_types():
        if same_type(known.ros_type, ros_type):
            yield from graph.get_services_of_type(known.ros_type)


def _users(graph: Graph, kind: EntityKind, topic: str) -> tuple[str, ...]:
    return _unique(info.node for info in graph.get_endpoints(kind=kind, name=_absolute(topic)))


def _visible(names_and_types: Mapping[str, str]) -> dict[str, str]:
    return {name: ros_type for name, ros_type in names_and_types.items() if not is_hidden(name)}


def _absolute(name: str) -> str:
    """Return *name* with the leading slash that some clients leave out."""
    return name if name.startswith("/") else f"/{name}"


def _unique(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(names)))


_Names: TypeAlias = tuple[str, ...]
_Types: TypeAlias = tuple[TypeDef, ...]
_DONE: Final = {"successful": bool, "reason": str}

SERVICES: Final = (
    RosApiService("topics", "Topics", {}, {"topics": _Names, "types": _Names}, _topics),
    RosApiService("topics_for_type", "TopicsForType", {"type": str}, {"topics": _Names}, _topics_of_type),
    RosApiService(
        "interfaces",
        "Interfaces",
        {},
        {"interfaces": _Names},
        lambda graph, _: {"interfaces": interfaces_of(graph).names()},
    ),
    RosApiService("topic_type", "TopicType", {"topic": str}, {"type": str}, _type_of_topic),
    RosApiService(
        "topics_and_raw_types",
        "TopicsAndRawTypes",
        {},
        {"topics": _Names, "types": _Names, "typedefs_full_text": _Names},
        _topics_with_texts,
    ),
    RosApiService(
        "message_details",
        "MessageDetails",
        {"type": str},
        {"typedefs": _Types},
        lambda graph, request: {"typedefs": typedefs_of(find_message_type(graph, request.type))},
    ),
    RosApiService(
        "publishers",
        "Publishers",
        {"topic": str},
        {"publishers": _Names},
        lambda graph, request: {"publishers": _users(graph, EntityKind.PUBLISHER, request.topic)},
    ),
    RosApiService(
        "subscribers",
        "Subscribers",
        {"topic": str},
        {"subscribers": _Names},
        lambda graph, request: {"subscribers": _users(graph, EntityKind.SUBSCRIPTION, request.topic)},
    ),
    RosApiService(
        "services",
        "Services",
        {},
        {"services": _Names},
        lambda graph, _: {"services": tuple(_visible(graph.get_service_names_and_types()))},
    ),
    RosApiService(
        "services_for_type",
        "ServicesForType",
        {"type": str},
        {"services": _Names},
        lambda graph, request: {
            "services": _unique(info.name for info in _served(graph, request.type) if not is_hidden(info.name))
        },
    ),
    RosApiService("service_type", "ServiceType", {"service": str}, {"type": str}, _type_of_service),
    RosApiService(
        "service_request_details",
        "ServiceRequestDetails",
        {"type": str},
        {"typedefs": _Types},
        lambda graph, request: {"typedefs": typedefs_of(find_service_type(graph, request.type).Request)},
    ),
    RosApiService(
        "service_response_details",
        "ServiceResponseDetails",
        {"type": str},
        {"typedefs": _Types},
        lambda graph, request: {"typedefs": typedefs_of(find_service_type(graph, request.type).Response)},
    ),
    RosApiService("service_node", "ServiceNode", {"service": str}, {"node": str}, _node_of_service),
    RosApiService(
        "service_providers",
        "ServiceProviders",
        {"service": str},
        {"providers": _Names},
        lambda graph, request: {"providers": _unique(info.node for info in _served(graph, request.service))},
    ),
    RosApiService(
        "nodes",
        "Nodes",
        {},
        {"nodes": _Names},
        lambda graph, _: {"nodes": tuple(name for name in graph.get_node_names() if not is_hidden(name))},
    ),
    RosApiService(
        "node_details",
        "NodeDetails",
        {"node": str},
        {"subscribing": _Names, "publishing": _Names, "services": _Names},
        _node_details,
    ),
    RosApiService("action_servers", "GetActionServers", {}, {"action_servers": _Names}, _action_servers),
    RosApiService("action_type", "ActionType", {"action": str}, {"type": str}, _type_of_action),
    *(
        RosApiService(
            f"action_{part.lower()}_details",
            f"Action{part}Details",
            {"type": str},
            {"typedefs": _Types},
            _details_of_action(part),
        )
        for part in ("Goal", "Result", "Feedback")
    ),
    RosApiService("get_time", "GetTime", {}, {"time": TimeOfBothKinds}, _time),
    RosApiService(
        "get_ros_version",
        "GetROSVersion",
        {},
        {"version": UInt8, "distro": str},
        lambda *_: {"version": 2, "distro": "homebot"},
    ),
    RosApiService(
        "get_param",
        "GetParam",
        {"name": str, "default_value": (str, "")},
        {"value": str, **_DONE},
        parameters.get_parameter,
    ),
    RosApiService("set_param", "SetParam", {"name": str, "value": str}, _DONE, parameters.set_parameter),
    RosApiService("delete_param", "DeleteParam", {"name": str}, _DONE, parameters.delete_parameter),
    RosApiService("has_param", "HasParam", {"name": str}, {"exists": bool}, parameters.has_parameter),
    RosApiService("get_param_names", "GetParamNames", {}, {"names": _Names}, parameters.list_parameters),
)


class RosApi:
    """Offers the rosapi services on *node*, and the definition of types; they go with it.

    Names that begin with an underscore are hidden, as in ROS; ``/rosapi/endpoints``, which is ours, shows them too.

    Args:
        node: The node that serves; its name should be ``rosapi``, though the services have that name in any case.
    """

    def __init__(self, node: Node) -> None:
        error_log = ClientErrorLog(node)
        for service in SERVICES:
            service.serve(node, error_log)
        node.create_service(DefineType, DEFINE_TYPE, partial(define_type, node.graph))
        node.create_service(FindEndpoints, "/rosapi/endpoints", partial(find_endpoints, node.graph))
