"""Messages of ``rosapi_msgs`` about nodes, time and the system, field for field.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.fields import Int32, UInt8, UInt32
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "GetActionServers",
    "GetActionServersRequest",
    "GetActionServersResponse",
    "GetROSVersion",
    "GetROSVersionRequest",
    "GetROSVersionResponse",
    "GetTime",
    "GetTimeRequest",
    "GetTimeResponse",
    "NodeDetails",
    "NodeDetailsRequest",
    "NodeDetailsResponse",
    "Nodes",
    "NodesRequest",
    "NodesResponse",
    "TimeOfBothKinds",
]


class TimeOfBothKinds(Message):
    """A point in time as ROS 2 and as ROS 1 spell it, since clients of both ask."""

    sec: Int32
    nanosec: UInt32
    secs: Int32
    nsecs: UInt32


class NodesRequest(Message):
    """A question for the names of all nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Nodes_Request"


class NodesResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Nodes_Response"

    nodes: tuple[str, ...]


class NodeDetailsRequest(Message):
    """A question for the topics and services of a node."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/NodeDetails_Request"

    node: str


class NodeDetailsResponse(Message):
    """The topics it reads, the topics it publishes on, and the services it serves."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/NodeDetails_Response"

    subscribing: tuple[str, ...]
    publishing: tuple[str, ...]
    services: tuple[str, ...]


class GetActionServersRequest(Message):
    """A question for the names of all actions."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetActionServers_Request"


class GetActionServersResponse(Message):
    """The actions."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetActionServers_Response"

    action_servers: tuple[str, ...]


class GetTimeRequest(Message):
    """A question for the time."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetTime_Request"


class GetTimeResponse(Message):
    """Now."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetTime_Response"

    time: TimeOfBothKinds


class GetROSVersionRequest(Message):
    """A question for the version of ROS."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetROSVersion_Request"


class GetROSVersionResponse(Message):
    """Its major version and its distribution."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetROSVersion_Response"

    version: UInt8
    distro: str


Nodes = ServiceType("rosapi_msgs/srv/Nodes", NodesRequest, NodesResponse)
NodeDetails = ServiceType("rosapi_msgs/srv/NodeDetails", NodeDetailsRequest, NodeDetailsResponse)
GetActionServers = ServiceType("rosapi_msgs/srv/GetActionServers", GetActionServersRequest, GetActionServersResponse)
GetTime = ServiceType("rosapi_msgs/srv/GetTime", GetTimeRequest, GetTimeResponse)
GetROSVersion = ServiceType("rosapi_msgs/srv/GetROSVersion", GetROSVersionRequest, GetROSVersionResponse)
