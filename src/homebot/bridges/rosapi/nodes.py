"""Services of ``/rosapi`` about nodes, time and the system, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from homebot.bridges.rosapi.typedefs import absolute, unique
from homebot.graph import EntityKind, Graph
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Int32, Message, ServiceType, UInt8, UInt32
from homebot.names import is_hidden

__all__ = [
    "GetActionServers",
    "GetROSVersion",
    "GetTime",
    "NodeDetails",
    "NodeDirectory",
    "Nodes",
]


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


Nodes = ServiceType("rosapi_msgs/srv/Nodes", NodesRequest, NodesResponse)
NodeDetails = ServiceType("rosapi_msgs/srv/NodeDetails", NodeDetailsRequest, NodeDetailsResponse)
GetActionServers = ServiceType("rosapi_msgs/srv/GetActionServers", GetActionServersRequest, GetActionServersResponse)
GetTime = ServiceType("rosapi_msgs/srv/GetTime", GetTimeRequest, GetTimeResponse)
GetROSVersion = ServiceType("rosapi_msgs/srv/GetROSVersion", GetROSVersionRequest, GetROSVersionResponse)


class NodeDirectory:
    """Answers questions about nodes, and what else is asked of the system.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: NodesRequest) -> NodesResponse:
        """Return every visible node."""
        return NodesResponse(nodes=tuple(name for name in self._graph.get_node_names() if not is_hidden(name)))

    def details(self, request: NodeDetailsRequest) -> NodeDetailsResponse:
        """Return what a node reads, publishes and serves; an unknown one does nothing."""
        ends = self._graph.get_endpoints(node=absolute(request.node))
        return NodeDetailsResponse(
            subscribing=unique(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
            publishing=unique(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
            services=unique(info.name for info in ends if info.kind is EntityKind.SERVICE),
        )

    def action_servers(self, _request: GetActionServersRequest) -> GetActionServersResponse:
        """Return every action."""
        topics = self._graph.get_topic_names_and_types()
        suffix = "/_action/status"  # every action server publishes this
        return GetActionServersResponse(
            action_servers=tuple(name.removesuffix(suffix) for name in topics if name.endswith(suffix))
        )

    def time(self, _request: GetTimeRequest) -> GetTimeResponse:
        """Return the graph's time."""
        now = Time.from_seconds(self._graph.clock.now())
        return GetTimeResponse(time=TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec))

    def ros_version(self, _request: GetROSVersionRequest) -> GetROSVersionResponse:
        """Return that this behaves like ROS 2."""
        return GetROSVersionResponse(version=2, distro="homebot")
