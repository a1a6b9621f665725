"""Services of ``/rosapi`` about nodes, time and the system, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from homebot.bridges.rosapi.typedefs import absolute, unique
from homebot.graph import EntityKind, Graph
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Int32, Message, UInt8, UInt32
from homebot.names import is_hidden

__all__ = ["SERVICES"]


class TimeOfBothKinds(Message):
    """A point in time as ROS 2 and as ROS 1 spell it, since clients of both ask."""

    sec: Int32
    nanosec: UInt32
    secs: Int32
    nsecs: UInt32


class NodesRequest(Message, ros_type="rosapi_msgs/srv/Nodes_Request"):
    """A question for the names of all nodes."""


class NodesResponse(Message, ros_type="rosapi_msgs/srv/Nodes_Response"):
    """The nodes."""

    nodes: tuple[str, ...]


class NodeDetailsRequest(Message, ros_type="rosapi_msgs/srv/NodeDetails_Request"):
    """A question for the topics and services of a node."""

    node: str


class NodeDetailsResponse(Message, ros_type="rosapi_msgs/srv/NodeDetails_Response"):
    """The topics it reads, the topics it publishes on, and the services it serves."""

    subscribing: tuple[str, ...]
    publishing: tuple[str, ...]
    services: tuple[str, ...]


class GetActionServersRequest(Message, ros_type="rosapi_msgs/srv/GetActionServers_Request"):
    """A question for the names of all actions."""


class GetActionServersResponse(Message, ros_type="rosapi_msgs/srv/GetActionServers_Response"):
    """The actions."""

    action_servers: tuple[str, ...]


class GetTimeRequest(Message, ros_type="rosapi_msgs/srv/GetTime_Request"):
    """A question for the time."""


class GetTimeResponse(Message, ros_type="rosapi_msgs/srv/GetTime_Response"):
    """Now."""

    time: TimeOfBothKinds


class GetROSVersionRequest(Message, ros_type="rosapi_msgs/srv/GetROSVersion_Request"):
    """A question for the version of ROS."""


class GetROSVersionResponse(Message, ros_type="rosapi_msgs/srv/GetROSVersion_Response"):
    """Its major version and its distribution."""

    version: UInt8
    distro: str


def list_nodes(graph: Graph, _request: NodesRequest) -> NodesResponse:
    """Return every visible node."""
    return NodesResponse(nodes=tuple(name for name in graph.get_node_names() if not is_hidden(name)))


def node_details(graph: Graph, request: NodeDetailsRequest) -> NodeDetailsResponse:
    """Return the subscriptions, publications and services of a node; empty for an unknown one."""
    ends = graph.get_endpoints(node=absolute(request.node))
    return NodeDetailsResponse(
        subscribing=unique(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
        publishing=unique(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
        services=unique(info.name for info in ends if info.kind is EntityKind.SERVICE),
    )


def list_action_servers(graph: Graph, _request: GetActionServersRequest) -> GetActionServersResponse:
    """Return every action."""
    topics = graph.get_topic_names_and_types()
    suffix = "/_action/status"  # every action server publishes this
    return GetActionServersResponse(
        action_servers=tuple(name.removesuffix(suffix) for name in topics if name.endswith(suffix))
    )


def get_time(graph: Graph, _request: GetTimeRequest) -> GetTimeResponse:
    """Return the graph's time."""
    now = Time.from_seconds(graph.clock.now())
    return GetTimeResponse(time=TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec))


def get_ros_version(_graph: Graph, _request: GetROSVersionRequest) -> GetROSVersionResponse:
    """Return that this behaves like ROS 2."""
    return GetROSVersionResponse(version=2, distro="homebot")


SERVICES: Mapping[str, tuple[type[Message], type[Message], Callable[[Graph, Any], Message]]] = {
    "nodes": (NodesRequest, NodesResponse, list_nodes),
    "node_details": (NodeDetailsRequest, NodeDetailsResponse, node_details),
    "action_servers": (GetActionServersRequest, GetActionServersResponse, list_action_servers),
    "get_time": (GetTimeRequest, GetTimeResponse, get_time),
    "get_ros_version": (GetROSVersionRequest, GetROSVersionResponse, get_ros_version),
}
"""Request, response and function of each service, by its name below ``/rosapi``."""
