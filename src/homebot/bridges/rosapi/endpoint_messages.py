"""A service of our own: everything on the graph in one answer, with its quality of service."""

from __future__ import annotations

from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "EndpointDetails",
    "FindEndpoints",
    "FindEndpointsRequest",
    "FindEndpointsResponse",
]


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


class FindEndpointsRequest(Message):
    """A question for everybody that uses a topic or service.

    Attributes:
        kind: ``node``, ``publisher``, ``subscription``, ``service`` or ``client``; empty for all.
        name: Full name of a topic or service; empty for all.
        node: Full name of a node; empty for all.
    """

    kind: str = ""
    name: str = ""
    node: str = ""


class FindEndpointsResponse(Message):
    """All that match, hidden ones too, sorted by name, kind and node."""

    endpoints: tuple[EndpointDetails, ...]


FindEndpoints = ServiceType("homebot/srv/FindEndpoints", FindEndpointsRequest, FindEndpointsResponse)
