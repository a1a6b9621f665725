"""Services of ``/rosapi`` about nodes, time and the system."""

from __future__ import annotations

from homebot.bridges.rosapi import node_messages as m
from homebot.bridges.rosapi.names import absolute, unique
from homebot.graph import EntityKind, Graph
from homebot.messages.builtin_interfaces import Time
from homebot.names import is_hidden

__all__ = ["NodeDirectory"]


class NodeDirectory:
    """Answers questions about nodes, and what else is asked of the system.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.NodesRequest) -> m.NodesResponse:
        """Return every visible node."""
        return m.NodesResponse(nodes=tuple(name for name in self._graph.get_node_names() if not is_hidden(name)))

    def details(self, request: m.NodeDetailsRequest) -> m.NodeDetailsResponse:
        """Return what a node reads, publishes and serves; an unknown one does nothing."""
        ends = self._graph.get_endpoints(node=absolute(request.node))
        return m.NodeDetailsResponse(
            subscribing=unique(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
            publishing=unique(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
            services=unique(info.name for info in ends if info.kind is EntityKind.SERVICE),
        )

    def action_servers(self, _request: m.GetActionServersRequest) -> m.GetActionServersResponse:
        """Return every action."""
        topics = self._graph.get_topic_names_and_types()
        suffix = "/_action/status"  # every action server publishes this
        return m.GetActionServersResponse(
            action_servers=tuple(name.removesuffix(suffix) for name in topics if name.endswith(suffix))
        )

    def time(self, _request: m.GetTimeRequest) -> m.GetTimeResponse:
        """Return the graph's time."""
        now = Time.from_seconds(self._graph.clock.now())
        return m.GetTimeResponse(
            time=m.TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec)
        )

    def ros_version(self, _request: m.GetROSVersionRequest) -> m.GetROSVersionResponse:
        """Return that this behaves like ROS 2."""
        return m.GetROSVersionResponse(version=2, distro="homebot")
