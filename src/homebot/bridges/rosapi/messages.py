"""The messages and service types of ``rosapi_msgs``, field for field, and one service of our own.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.fields import Int32, UInt8, UInt32
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "DeleteParam",
    "EndpointDetails",
    "FindEndpoints",
    "FindEndpointsResponse",
    "GetActionServers",
    "GetParam",
    "GetParamNames",
    "GetROSVersion",
    "GetTime",
    "HasParam",
    "MessageDetails",
    "NodeDetails",
    "Nodes",
    "Publishers",
    "ServiceNode",
    "ServiceProviders",
    "ServiceRequestDetails",
    "ServiceResponseDetails",
    "ServiceTypeOf",
    "Services",
    "ServicesForType",
    "SetParam",
    "Subscribers",
    "TimeOfBothKinds",
    "TopicType",
    "Topics",
    "TopicsAndRawTypes",
    "TopicsForType",
    "TypeDef",
]


class TypeDef(Message):
    """What a message type looks like.

    Attributes:
        type: Its name, as ``package/Name``.
        fieldnames: Its fields.
        fieldtypes: The fields' types; of one element where the field is an array.
        fieldarraylen: -1 for one value, 0 for any number of values, else exactly that many.
        examples: A value of each field, as text.
        constnames: Its constants.
        constvalues: Their values, as text.
    """

    ros_type: ClassVar[str] = "rosapi_msgs/msg/TypeDef"

    type: str
    fieldnames: tuple[str, ...]
    fieldtypes: tuple[str, ...]
    fieldarraylen: tuple[Int32, ...]
    examples: tuple[str, ...]
    constnames: tuple[str, ...] = ()
    constvalues: tuple[str, ...] = ()


class TimeOfBothKinds(Message):
    """A point in time as ROS 2 and as ROS 1 spell it, since clients of both ask."""

    sec: Int32
    nanosec: UInt32
    secs: Int32
    nsecs: UInt32


class TopicsRequest(Message):
    """Which topics are there?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Topics_Request"


class TopicsResponse(Message):
    """The topics and their types, in the same order."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Topics_Response"

    topics: tuple[str, ...]
    types: tuple[str, ...]


class TopicsForTypeRequest(Message):
    """Which topics carry a type?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsForType_Request"

    type: str


class TopicsForTypeResponse(Message):
    """The topics."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsForType_Response"

    topics: tuple[str, ...]


class TopicTypeRequest(Message):
    """What does a topic carry?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicType_Request"

    topic: str


class TopicTypeResponse(Message):
    """Its type, empty where there is no such topic."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicType_Response"

    type: str


class TopicsAndRawTypesRequest(Message):
    """Which topics are there, and what do their types look like?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsAndRawTypes_Request"


class TopicsAndRawTypesResponse(Message):
    """The topics, their types and the full texts of those, in the same order."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/TopicsAndRawTypes_Response"

    topics: tuple[str, ...]
    types: tuple[str, ...]
    typedefs_full_text: tuple[str, ...]


class ServicesRequest(Message):
    """Which services are there?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Services_Request"


class ServicesResponse(Message):
    """The services."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Services_Response"

    services: tuple[str, ...]


class ServicesForTypeRequest(Message):
    """Which services are of a type?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServicesForType_Request"

    type: str


class ServicesForTypeResponse(Message):
    """The services."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServicesForType_Response"

    services: tuple[str, ...]


class ServiceTypeRequest(Message):
    """Of which type is a service?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceType_Request"

    service: str


class ServiceTypeResponse(Message):
    """Its type, empty where there is no such service."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceType_Response"

    type: str


class ServiceRequestDetailsRequest(Message):
    """What does the request of a service type look like?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceRequestDetails_Request"

    type: str


class ServiceRequestDetailsResponse(Message):
    """The request and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceRequestDetails_Response"

    typedefs: tuple[TypeDef, ...]


class ServiceResponseDetailsRequest(Message):
    """What does the response of a service type look like?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceResponseDetails_Request"

    type: str


class ServiceResponseDetailsResponse(Message):
    """The response and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceResponseDetails_Response"

    typedefs: tuple[TypeDef, ...]


class MessageDetailsRequest(Message):
    """What does a message type look like?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/MessageDetails_Request"

    type: str


class MessageDetailsResponse(Message):
    """The type and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/MessageDetails_Response"

    typedefs: tuple[TypeDef, ...]


class NodesRequest(Message):
    """Which nodes are there?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Nodes_Request"


class NodesResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Nodes_Response"

    nodes: tuple[str, ...]


class NodeDetailsRequest(Message):
    """What does a node do?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/NodeDetails_Request"

    node: str


class NodeDetailsResponse(Message):
    """The topics it reads, the topics it publishes on, and the services it serves."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/NodeDetails_Response"

    subscribing: tuple[str, ...]
    publishing: tuple[str, ...]
    services: tuple[str, ...]


class PublishersRequest(Message):
    """Who publishes on a topic?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Publishers_Request"

    topic: str


class PublishersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Publishers_Response"

    publishers: tuple[str, ...]


class SubscribersRequest(Message):
    """Who reads a topic?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Subscribers_Request"

    topic: str


class SubscribersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Subscribers_Response"

    subscribers: tuple[str, ...]


class ServiceNodeRequest(Message):
    """Who serves a service?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceNode_Request"

    service: str


class ServiceNodeResponse(Message):
    """The node, empty where there is none."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceNode_Response"

    node: str


class ServiceProvidersRequest(Message):
    """Who serves services of a type?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceProviders_Request"

    service: str


class ServiceProvidersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceProviders_Response"

    providers: tuple[str, ...]


class GetActionServersRequest(Message):
    """Which actions are there?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetActionServers_Request"


class GetActionServersResponse(Message):
    """The actions."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetActionServers_Response"

    action_servers: tuple[str, ...]


class GetParamRequest(Message):
    """What is the value of the parameter ``/node:name``?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParam_Request"

    name: str
    default_value: str = ""


class GetParamResponse(Message):
    """Its value as JSON text; ``null`` and the reason where there is none."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParam_Response"

    value: str
    successful: bool
    reason: str


class SetParamRequest(Message):
    """Give the parameter ``/node:name`` a value, written as JSON text."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/SetParam_Request"

    name: str
    value: str


class SetParamResponse(Message):
    """Whether it was taken, and why not."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/SetParam_Response"

    successful: bool
    reason: str


class DeleteParamRequest(Message):
    """Delete the parameter ``/node:name``."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/DeleteParam_Request"

    name: str


class DeleteParamResponse(Message):
    """Whether it was deleted, and why not."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/DeleteParam_Response"

    successful: bool
    reason: str


class HasParamRequest(Message):
    """Is there a parameter ``/node:name``?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/HasParam_Request"

    name: str


class HasParamResponse(Message):
    """Whether there is."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/HasParam_Response"

    exists: bool


class GetParamNamesRequest(Message):
    """Which parameters are there?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParamNames_Request"


class GetParamNamesResponse(Message):
    """Their names, as ``/node:name``."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParamNames_Response"

    names: tuple[str, ...]


class GetTimeRequest(Message):
    """What time is it?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetTime_Request"


class GetTimeResponse(Message):
    """Now."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetTime_Response"

    time: TimeOfBothKinds


class GetROSVersionRequest(Message):
    """Which ROS is this?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetROSVersion_Request"


class GetROSVersionResponse(Message):
    """Its major version and its distribution."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetROSVersion_Response"

    version: UInt8
    distro: str


class FindEndpointsRequest(Message):
    """Who uses what?

    Attributes:
        kind: ``node``, ``publisher``, ``subscription``, ``service`` or ``client``; empty for all.
        name: Full name of a topic or service; empty for all.
        node: Full name of a node; empty for all.
    """

    kind: str = ""
    name: str = ""
    node: str = ""


class EndpointDetails(Message):
    """One node, or one end of a topic or service.

    Attributes:
        kind: ``node``, ``publisher``, ``subscription``, ``service`` or ``client``.
        node: Full name of its node.
        name: Full name of its topic or service; of the node, where it is one.
        type: Full ROS type; empty for a node.
        reliability: ``reliable`` or ``best_effort``; empty for what has no quality of service.
        durability: ``volatile`` or ``transient_local``; empty likewise.
        history: ``keep_last`` or ``keep_all``; empty likewise.
        depth: Messages kept; 0 likewise.
        lifespan: Seconds; 0 is for ever.
        deadline: Seconds; 0 is any.
        liveliness: ``automatic`` or ``manual_by_topic``; empty likewise.
        liveliness_lease_duration: Seconds; 0 is for ever.
    """

    kind: str
    node: str
    name: str
    type: str
    reliability: str = ""
    durability: str = ""
    history: str = ""
    depth: int = 0
    lifespan: float = 0.0
    deadline: float = 0.0
    liveliness: str = ""
    liveliness_lease_duration: float = 0.0


class FindEndpointsResponse(Message):
    """All that match, hidden ones too, sorted by name, kind and node."""

    endpoints: tuple[EndpointDetails, ...]


Topics = ServiceType("rosapi_msgs/srv/Topics", TopicsRequest, TopicsResponse)
TopicsForType = ServiceType("rosapi_msgs/srv/TopicsForType", TopicsForTypeRequest, TopicsForTypeResponse)
TopicType = ServiceType("rosapi_msgs/srv/TopicType", TopicTypeRequest, TopicTypeResponse)
TopicsAndRawTypes = ServiceType(
    "rosapi_msgs/srv/TopicsAndRawTypes", TopicsAndRawTypesRequest, TopicsAndRawTypesResponse
)
Services = ServiceType("rosapi_msgs/srv/Services", ServicesRequest, ServicesResponse)
ServicesForType = ServiceType("rosapi_msgs/srv/ServicesForType", ServicesForTypeRequest, ServicesForTypeResponse)
ServiceTypeOf = ServiceType("rosapi_msgs/srv/ServiceType", ServiceTypeRequest, ServiceTypeResponse)
ServiceRequestDetails = ServiceType(
    "rosapi_msgs/srv/ServiceRequestDetails", ServiceRequestDetailsRequest, ServiceRequestDetailsResponse
)
ServiceResponseDetails = ServiceType(
    "rosapi_msgs/srv/ServiceResponseDetails", ServiceResponseDetailsRequest, ServiceResponseDetailsResponse
)
MessageDetails = ServiceType("rosapi_msgs/srv/MessageDetails", MessageDetailsRequest, MessageDetailsResponse)
Nodes = ServiceType("rosapi_msgs/srv/Nodes", NodesRequest, NodesResponse)
NodeDetails = ServiceType("rosapi_msgs/srv/NodeDetails", NodeDetailsRequest, NodeDetailsResponse)
Publishers = ServiceType("rosapi_msgs/srv/Publishers", PublishersRequest, PublishersResponse)
Subscribers = ServiceType("rosapi_msgs/srv/Subscribers", SubscribersRequest, SubscribersResponse)
ServiceNode = ServiceType("rosapi_msgs/srv/ServiceNode", ServiceNodeRequest, ServiceNodeResponse)
ServiceProviders = ServiceType("rosapi_msgs/srv/ServiceProviders", ServiceProvidersRequest, ServiceProvidersResponse)
GetActionServers = ServiceType("rosapi_msgs/srv/GetActionServers", GetActionServersRequest, GetActionServersResponse)
GetParam = ServiceType("rosapi_msgs/srv/GetParam", GetParamRequest, GetParamResponse)
SetParam = ServiceType("rosapi_msgs/srv/SetParam", SetParamRequest, SetParamResponse)
DeleteParam = ServiceType("rosapi_msgs/srv/DeleteParam", DeleteParamRequest, DeleteParamResponse)
HasParam = ServiceType("rosapi_msgs/srv/HasParam", HasParamRequest, HasParamResponse)
GetParamNames = ServiceType("rosapi_msgs/srv/GetParamNames", GetParamNamesRequest, GetParamNamesResponse)
GetTime = ServiceType("rosapi_msgs/srv/GetTime", GetTimeRequest, GetTimeResponse)
GetROSVersion = ServiceType("rosapi_msgs/srv/GetROSVersion", GetROSVersionRequest, GetROSVersionResponse)
FindEndpoints = ServiceType("homebot/srv/FindEndpoints", FindEndpointsRequest, FindEndpointsResponse)
