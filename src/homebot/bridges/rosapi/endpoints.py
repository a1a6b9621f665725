"""The graph's entities as messages."""

from __future__ import annotations

from homebot.bridges.rosapi.endpoint_messages import EndpointDetails, FindEndpointsRequest, FindEndpointsResponse
from homebot.errors import RefusedError
from homebot.graph import EndpointInfo, EntityKind, Graph

__all__ = ["find_endpoints"]


def find_endpoints(graph: Graph, request: FindEndpointsRequest) -> FindEndpointsResponse:
    """Return every entity that matches *request*.

    Raises:
        RefusedError: There is no such kind.
    """
    kinds = {kind.value for kind in EntityKind}
    if request.kind and request.kind not in kinds:
        raise RefusedError("the search", f"field 'kind' is one of {', '.join(sorted(kinds))}, got {request.kind!r}")
    found = graph.get_endpoints(
        kind=EntityKind(request.kind) if request.kind else None, name=request.name or None, node=request.node or None
    )
    ordered = sorted(found, key=lambda info: (info.name, info.kind, info.node))
    return FindEndpointsResponse(endpoints=tuple(_details(info) for info in ordered))


def _details(info: EndpointInfo) -> EndpointDetails:
    if info.qos is None:
        return EndpointDetails(kind=info.kind.value, node=info.node, name=info.name, type=info.ros_type)
    return EndpointDetails(
        kind=info.kind.value,
        node=info.node,
        name=info.name,
        type=info.ros_type,
        reliability=info.qos.reliability.name.lower(),
        durability=info.qos.durability.name.lower(),
        history=info.qos.history.name.lower(),
        depth=info.qos.queue_depth,
        lifespan=float(info.qos.lifespan),
        deadline=float(info.qos.deadline),
        liveliness=info.qos.liveliness.name.lower(),
        liveliness_lease_duration=float(info.qos.liveliness_lease_duration),
    )
