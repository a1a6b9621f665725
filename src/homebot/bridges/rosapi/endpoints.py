"""A service of our own: everything on the graph in one answer, with its quality of service."""

from functools import partial
from typing import Any

from homebot.errors import RefusedError
from homebot.graph import EndpointInfo, EntityKind, Graph, Node
from homebot.messages.message import Message, ServiceType


class EndpointDetails(Message):
    """One node, or one end of a topic or service.

    Attributes:
        kind: ``node``, ``publisher``, ``subscription``, ``service``, ``client``, ``action server`` or
            ``action client``.
        node: Full name of its node.
        name: Full name of its topic or service; of the node, where it is one.
        type: Full ROS type; empty for a node.
        reliability: ``reliable`` or ``best_effort``; empty without QoS.
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


class FindEndpointsRequest(Message):
    """A question for everything of a kind, a full name and a node; each is any where it is empty.

    Attributes:
        elsewhere: Whether for the nodes of robots and other machines in place of those here.
    """

    kind: str = ""
    name: str = ""
    node: str = ""
    elsewhere: bool = False


class FindEndpointsResponse(Message):
    """All that match, hidden ones too, sorted by name, kind and node."""

    endpoints: tuple[EndpointDetails, ...]


def _find_endpoints(graph: Graph, request: FindEndpointsRequest) -> FindEndpointsResponse:
    """Return every entity that matches *request*."""
    kinds = {kind.value for kind in EntityKind}
    if request.kind and request.kind not in kinds:
        raise RefusedError("the search", f"field 'kind' is one of {', '.join(sorted(kinds))}, got {request.kind!r}")
    kind = EntityKind(request.kind) if request.kind else None
    name, node = request.name or None, request.node or None
    if request.elsewhere:
        endpoints = graph.elsewhere.find(kind, name, node)
    else:
        endpoints = graph.get_endpoints(kind=kind, name=name, node=node)
    ordered = sorted(endpoints, key=lambda info: (info.name, info.kind, info.node))
    return FindEndpointsResponse(endpoints=tuple(_details(info) for info in ordered))


def _details(info: EndpointInfo) -> EndpointDetails:
    policies: dict[str, Any] = {} if info.qos is None else info.qos.to_plain()
    return EndpointDetails(kind=info.kind.value, node=info.node, name=info.name, type=info.ros_type, **policies)


FindEndpoints = ServiceType("homebot/srv/FindEndpoints", FindEndpointsRequest, FindEndpointsResponse)


def serve(node: Node) -> None:
    """Offer the service on *node*."""
    node.create_service(FindEndpoints, "/rosapi/endpoints", partial(_find_endpoints, node.graph))
