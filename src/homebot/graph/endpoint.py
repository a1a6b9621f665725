"""Description of one end of a topic or service, for the look-up directory."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from homebot.graph.qos import QoSProfile

__all__ = ["EndpointInfo", "EntityKind", "GraphChange"]


class EntityKind(StrEnum):
    """The kinds of entities on the graph."""

    NODE = "node"
    PUBLISHER = "publisher"
    SUBSCRIPTION = "subscription"
    SERVICE = "service"
    CLIENT = "client"


@dataclass(frozen=True, slots=True)
class EndpointInfo:
    """One entity on the graph.

    Attributes:
        kind: What it is.
        node: Full name of the node that owns it (its own name where it is a node).
        name: Full name of its topic or service (of the node, where it is one).
        ros_type: Full ROS type name, empty for a node.
        qos: What it offers or requests; None for nodes, services and clients.
    """

    kind: EntityKind
    node: str
    name: str
    ros_type: str = ""
    qos: QoSProfile | None = None


@dataclass(frozen=True, slots=True)
class GraphChange:
    """One entity came or went.

    Attributes:
        change: ``added`` or ``removed``.
        entity: Which.
    """

    change: Literal["added", "removed"]
    entity: EndpointInfo
