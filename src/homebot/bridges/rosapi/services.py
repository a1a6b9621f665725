"""Services of ``/rosapi`` about services."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.bridges.rosapi import service_messages as m
from homebot.bridges.rosapi.names import absolute, unique
from homebot.bridges.rosapi.typedefs import typedefs_of
from homebot.bridges.rosbridge.types import find_service_type, same_type
from homebot.graph import EndpointInfo, EntityKind, Graph
from homebot.names import is_hidden

__all__ = ["ServiceDirectory"]


class ServiceDirectory:
    """Answers questions about services.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.ServicesRequest) -> m.ServicesResponse:
        """Return every visible service."""
        return m.ServicesResponse(services=tuple(self._visible()))

    def for_type(self, request: m.ServicesForTypeRequest) -> m.ServicesForTypeResponse:
        """Return the visible services of a type."""
        found = (info.name for info in self._served(request.type) if not is_hidden(info.name))
        return m.ServicesForTypeResponse(services=unique(found))

    def type_of(self, request: m.ServiceTypeRequest) -> m.ServiceTypeResponse:
        """Return the type of a service."""
        found = self._graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
        return m.ServiceTypeResponse(type=found[0].ros_type if found else "")

    def request_details(self, request: m.ServiceRequestDetailsRequest) -> m.ServiceRequestDetailsResponse:
        """Return what the request of a service type looks like; an unknown one is a PeerError."""
        found = find_service_type(self._graph, request.type)
        return m.ServiceRequestDetailsResponse(typedefs=typedefs_of(found.Request))

    def response_details(self, request: m.ServiceResponseDetailsRequest) -> m.ServiceResponseDetailsResponse:
        """Return what the response of a service type looks like; an unknown one is a PeerError."""
        found = find_service_type(self._graph, request.type)
        return m.ServiceResponseDetailsResponse(typedefs=typedefs_of(found.Response))

    def node_of(self, request: m.ServiceNodeRequest) -> m.ServiceNodeResponse:
        """Return who serves a service."""
        found = self._graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute(request.service))
        return m.ServiceNodeResponse(node=found[0].node if found else "")

    def providers(self, request: m.ServiceProvidersRequest) -> m.ServiceProvidersResponse:
        """Return who serves services of a type."""
        return m.ServiceProvidersResponse(providers=unique(info.node for info in self._served(request.service)))

    def _served(self, ros_type: str) -> Iterator[EndpointInfo]:
        for known in self._graph.get_service_types():
            if same_type(known.ros_type, ros_type):
                yield from self._graph.get_services_of_type(known.ros_type)

    def _visible(self) -> dict[str, str]:
        services = self._graph.get_service_names_and_types().items()
        return {name: ros_type for name, ros_type in services if not is_hidden(name)}
