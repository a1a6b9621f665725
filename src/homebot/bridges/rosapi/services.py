"""Services of ``/rosapi`` about services, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from collections.abc import Iterator

from homebot.bridges.rosapi.typedefs import TypeDef, absolute, typedefs_of, unique
from homebot.bridges.rosbridge.types import find_service_type, same_type
from homebot.graph import EndpointInfo, EntityKind, Graph
from homebot.messages.message import Message, ServiceType
from homebot.names import is_hidden

__all__ = [
    "ServiceDirectory",
    "ServiceNode",
    "ServiceProviders",
    "ServiceRequestDetails",
    "ServiceResponseDetails",
    "ServiceTypeOf",
    "Services",
    "ServicesForType",
]


class ServicesRequest(Message, ros_type="rosapi_msgs/srv/Services_Request"):
    """A question for the names of all services."""


class ServicesResponse(Message, ros_type="rosapi_msgs/srv/Services_Response"):
    """The services."""

    services: tuple[str, ...]


class ServicesForTypeRequest(Message, ros_type="rosapi_msgs/srv/ServicesForType_Request"):
    """A question for the services of a type."""

    type: str


class ServicesForTypeResponse(Message, ros_type="rosapi_msgs/srv/ServicesForType_Response"):
    """The services."""

    services: tuple[str, ...]


class ServiceTypeRequest(Message, ros_type="rosapi_msgs/srv/ServiceType_Request"):
    """Of which type is a service?"""

    service: str


class ServiceTypeResponse(Message, ros_type="rosapi_msgs/srv/ServiceType_Response"):
    """Its type, empty where there is no such service."""

    type: str


class ServiceRequestDetailsRequest(Message, ros_type="rosapi_msgs/srv/ServiceRequestDetails_Request"):
    """A question for the fields of a service type's request."""

    type: str


class ServiceRequestDetailsResponse(Message, ros_type="rosapi_msgs/srv/ServiceRequestDetails_Response"):
    """The request and every type in it."""

    typedefs: tuple[TypeDef, ...]


class ServiceResponseDetailsRequest(Message, ros_type="rosapi_msgs/srv/ServiceResponseDetails_Request"):
    """A question for the fields of a service type's response."""

    type: str


class ServiceResponseDetailsResponse(Message, ros_type="rosapi_msgs/srv/ServiceResponseDetails_Response"):
    """The response and every type in it."""

    typedefs: tuple[TypeDef, ...]


class ServiceNodeRequest(Message, ros_type="rosapi_msgs/srv/ServiceNode_Request"):
    """A question for the node that serves a service."""

    service: str


class ServiceNodeResponse(Message, ros_type="rosapi_msgs/srv/ServiceNode_Response"):
    """The node, empty where there is none."""

    node: str


class ServiceProvidersRequest(Message, ros_type="rosapi_msgs/srv/ServiceProviders_Request"):
    """A question for the nodes that serve services of a type."""

    service: str


class ServiceProvidersResponse(Message, ros_type="rosapi_msgs/srv/ServiceProviders_Response"):
    """The nodes."""

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


class ServiceDirectory:
    """Answers questions about services.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: ServicesRequest) -> ServicesResponse:
        """Return every visible service."""
        return ServicesResponse(services=tuple(self._visible()))

    def for_type(self, request: ServicesForTypeRequest) -> ServicesForTypeResponse:
        """Return the visible services of a type."""
        found = (info.name for info in self._served(request.type) if not is_hidden(info.name))
        return ServicesForTypeResponse(services=unique(found))

    def type_of(self, request: ServiceTypeRequest) -> ServiceTypeResponse:
        """Return the type of a service."""
        found = self._graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
        return ServiceTypeResponse(type=found[0].ros_type if found else "")

    def request_details(self, request: ServiceRequestDetailsRequest) -> ServiceRequestDetailsResponse:
        """Return what the request of a service type looks like; an unknown one is a PeerError."""
        found = find_service_type(self._graph, request.type)
        return ServiceRequestDetailsResponse(typedefs=typedefs_of(found.Request))

    def response_details(self, request: ServiceResponseDetailsRequest) -> ServiceResponseDetailsResponse:
        """Return what the response of a service type looks like; an unknown one is a PeerError."""
        found = find_service_type(self._graph, request.type)
        return ServiceResponseDetailsResponse(typedefs=typedefs_of(found.Response))

    def node_of(self, request: ServiceNodeRequest) -> ServiceNodeResponse:
        """Return the node that serves a service."""
        found = self._graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
        return ServiceNodeResponse(node=found[0].node if found else "")

    def providers(self, request: ServiceProvidersRequest) -> ServiceProvidersResponse:
        """Return the nodes that serve services of a type."""
        return ServiceProvidersResponse(providers=unique(info.node for info in self._served(request.service)))

    def _served(self, ros_type: str) -> Iterator[EndpointInfo]:
        for known in self._graph.get_service_types():
            if same_type(known.ros_type, ros_type):
                yield from self._graph.get_services_of_type(known.ros_type)

    def _visible(self) -> dict[str, str]:
        services = self._graph.get_service_names_and_types().items()
        return {name: ros_type for name, ros_type in services if not is_hidden(name)}
