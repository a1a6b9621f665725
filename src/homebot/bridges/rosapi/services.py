"""Services of ``/rosapi`` about services, and their messages, field for field as in ``rosapi_msgs``.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from homebot.bridges.rosapi.typedefs import TypeDef, absolute, typedefs_of, unique
from homebot.bridges.rosbridge.types import find_service_type, same_type
from homebot.graph import EndpointInfo, EntityKind, Graph
from homebot.messages.message import Message
from homebot.names import is_hidden

__all__ = ["SERVICES"]


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


def list_services(graph: Graph, _request: ServicesRequest) -> ServicesResponse:
    """Return every visible service."""
    return ServicesResponse(services=tuple(_visible(graph)))


def services_for_type(graph: Graph, request: ServicesForTypeRequest) -> ServicesForTypeResponse:
    """Return the visible services of a type."""
    found = (info.name for info in _served(graph, request.type) if not is_hidden(info.name))
    return ServicesForTypeResponse(services=unique(found))


def type_of_service(graph: Graph, request: ServiceTypeRequest) -> ServiceTypeResponse:
    """Return the type of a service."""
    found = graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
    return ServiceTypeResponse(type=found[0].ros_type if found else "")


def request_details(graph: Graph, request: ServiceRequestDetailsRequest) -> ServiceRequestDetailsResponse:
    """Return the fields of the request of a service type; an unknown one is a PeerError."""
    found = find_service_type(graph, request.type)
    return ServiceRequestDetailsResponse(typedefs=typedefs_of(found.Request))


def response_details(graph: Graph, request: ServiceResponseDetailsRequest) -> ServiceResponseDetailsResponse:
    """Return the fields of the response of a service type; an unknown one is a PeerError."""
    found = find_service_type(graph, request.type)
    return ServiceResponseDetailsResponse(typedefs=typedefs_of(found.Response))


def node_of_service(graph: Graph, request: ServiceNodeRequest) -> ServiceNodeResponse:
    """Return the node that serves a service."""
    found = graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
    return ServiceNodeResponse(node=found[0].node if found else "")


def providers_of(graph: Graph, request: ServiceProvidersRequest) -> ServiceProvidersResponse:
    """Return the nodes that serve services of a type."""
    return ServiceProvidersResponse(providers=unique(info.node for info in _served(graph, request.service)))


def _served(graph: Graph, ros_type: str) -> Iterator[EndpointInfo]:
    for known in graph.get_service_types():
        if same_type(known.ros_type, ros_type):
            yield from graph.get_services_of_type(known.ros_type)


def _visible(graph: Graph) -> dict[str, str]:
    services = graph.get_service_names_and_types().items()
    return {name: ros_type for name, ros_type in services if not is_hidden(name)}


SERVICES: Mapping[str, tuple[type[Message], type[Message], Callable[[Graph, Any], Message]]] = {
    "services": (ServicesRequest, ServicesResponse, list_services),
    "services_for_type": (ServicesForTypeRequest, ServicesForTypeResponse, services_for_type),
    "service_type": (ServiceTypeRequest, ServiceTypeResponse, type_of_service),
    "service_request_details": (ServiceRequestDetailsRequest, ServiceRequestDetailsResponse, request_details),
    "service_response_details": (ServiceResponseDetailsRequest, ServiceResponseDetailsResponse, response_details),
    "service_node": (ServiceNodeRequest, ServiceNodeResponse, node_of_service),
    "service_providers": (ServiceProvidersRequest, ServiceProvidersResponse, providers_of),
}
"""Request, response and function of each service, by its name below ``/rosapi``."""
