"""Messages of ``rosapi_msgs`` about services, field for field.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.bridges.rosapi.topic_messages import TypeDef
from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "ServiceNode",
    "ServiceNodeRequest",
    "ServiceNodeResponse",
    "ServiceProviders",
    "ServiceProvidersRequest",
    "ServiceProvidersResponse",
    "ServiceRequestDetails",
    "ServiceRequestDetailsRequest",
    "ServiceRequestDetailsResponse",
    "ServiceResponseDetails",
    "ServiceResponseDetailsRequest",
    "ServiceResponseDetailsResponse",
    "ServiceTypeOf",
    "ServiceTypeRequest",
    "ServiceTypeResponse",
    "Services",
    "ServicesForType",
    "ServicesForTypeRequest",
    "ServicesForTypeResponse",
    "ServicesRequest",
    "ServicesResponse",
]


class ServicesRequest(Message):
    """A question for the names of all services."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Services_Request"


class ServicesResponse(Message):
    """The services."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/Services_Response"

    services: tuple[str, ...]


class ServicesForTypeRequest(Message):
    """A question for the services of a type."""

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
    """A question for the fields of a service type's request."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceRequestDetails_Request"

    type: str


class ServiceRequestDetailsResponse(Message):
    """The request and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceRequestDetails_Response"

    typedefs: tuple[TypeDef, ...]


class ServiceResponseDetailsRequest(Message):
    """A question for the fields of a service type's response."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceResponseDetails_Request"

    type: str


class ServiceResponseDetailsResponse(Message):
    """The response and every type in it."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceResponseDetails_Response"

    typedefs: tuple[TypeDef, ...]


class ServiceNodeRequest(Message):
    """A question for the node that serves a service."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceNode_Request"

    service: str


class ServiceNodeResponse(Message):
    """The node, empty where there is none."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceNode_Response"

    node: str


class ServiceProvidersRequest(Message):
    """A question for the nodes that serve services of a type."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceProviders_Request"

    service: str


class ServiceProvidersResponse(Message):
    """The nodes."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/ServiceProviders_Response"

    providers: tuple[str, ...]


Services = ServiceType("rosapi_msgs/srv/Services", ServicesRequest, ServicesResponse)
ServicesForType = ServiceType("rosapi_msgs/srv/ServicesForType", ServicesForTypeRequest, ServicesForTypeResponse)
ServiceTypeOf = ServiceType("rosapi_msgs/srv/ServiceType", ServiceTypeRequest, ServiceTypeResponse)
ServiceRequestDetails = ServiceType(
    "rosapi_msgs/srv/ServiceRequestDetails", ServiceRequestDetailsRequest, ServiceRequestDetailsResponse
)
ServiceResponseDetails = ServiceType(
    "rosapi_msgs/srv/ServiceResponseDetails", ServiceResponseDetailsRequest, ServiceResponseDetailsResponse
)
ServiceNode = ServiceType("rosapi_msgs/srv/ServiceNode", ServiceNodeRequest, ServiceNodeResponse)
ServiceProviders = ServiceType("rosapi_msgs/srv/ServiceProviders", ServiceProvidersRequest, ServiceProvidersResponse)
