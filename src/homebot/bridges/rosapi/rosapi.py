"""The services of ``/rosapi``; answers are those of the original, with ROS 2's full type names.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi/scripts/rosapi_node`` and ``rosapi/src/rosapi``.
"""

from __future__ import annotations

from collections.abc import Iterable

from homebot.bridges.rosapi import messages as m
from homebot.bridges.rosapi.endpoints import find_endpoints
from homebot.bridges.rosapi.parameters import GraphParameters
from homebot.bridges.rosapi.typedefs import typedefs_of
from homebot.bridges.rosbridge.types import find_message_type, find_service_type, same_type
from homebot.graph import EntityKind, Graph, Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import definition_text
from homebot.names import is_hidden

__all__ = ["Rosapi"]


class Rosapi:
    """Offers the rosapi services on *node*; they go with it.

    Names that begin with an underscore are hidden, as in ROS; ``/rosapi/endpoints``, which is ours, shows them too.

    Args:
        node: The node that serves; its name should be ``rosapi``, though the services have that name in any case.
    """

    def __init__(self, node: Node) -> None:
        graph = node.graph
        topics, services, nodes = _Topics(graph), _Services(graph), _Nodes(graph)
        parameters = GraphParameters(graph)
        node.create_service(m.Topics, "/rosapi/topics", topics.all)
        node.create_service(m.TopicsForType, "/rosapi/topics_for_type", topics.for_type)
        node.create_service(m.TopicType, "/rosapi/topic_type", topics.type_of)
        node.create_service(m.TopicsAndRawTypes, "/rosapi/topics_and_raw_types", topics.all_with_text)
        node.create_service(m.MessageDetails, "/rosapi/message_details", topics.details)
        node.create_service(m.Publishers, "/rosapi/publishers", topics.publishers)
        node.create_service(m.Subscribers, "/rosapi/subscribers", topics.subscribers)
        node.create_service(m.Services, "/rosapi/services", services.all)
        node.create_service(m.ServicesForType, "/rosapi/services_for_type", services.for_type)
        node.create_service(m.ServiceTypeOf, "/rosapi/service_type", services.type_of)
        node.create_service(m.ServiceRequestDetails, "/rosapi/service_request_details", services.request_details)
        node.create_service(m.ServiceResponseDetails, "/rosapi/service_response_details", services.response_details)
        node.create_service(m.ServiceNode, "/rosapi/service_node", services.node_of)
        node.create_service(m.ServiceProviders, "/rosapi/service_providers", services.providers)
        node.create_service(m.Nodes, "/rosapi/nodes", nodes.all)
        node.create_service(m.NodeDetails, "/rosapi/node_details", nodes.details)
        node.create_service(m.GetActionServers, "/rosapi/action_servers", nodes.action_servers)
        node.create_service(m.GetTime, "/rosapi/get_time", nodes.time)
        node.create_service(m.GetROSVersion, "/rosapi/get_ros_version", nodes.ros_version)
        node.create_service(m.GetParam, "/rosapi/get_param", parameters.get)
        node.create_service(m.SetParam, "/rosapi/set_param", parameters.set)
        node.create_service(m.DeleteParam, "/rosapi/delete_param", parameters.delete)
        node.create_service(m.HasParam, "/rosapi/has_param", parameters.has)
        node.create_service(m.GetParamNames, "/rosapi/get_param_names", parameters.names)
        node.create_service(m.FindEndpoints, "/rosapi/endpoints", lambda request: find_endpoints(graph, request))


class _Topics:
    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.TopicsRequest) -> m.TopicsResponse:
        topics = self._visible()
        return m.TopicsResponse(topics=tuple(topics), types=tuple(topics.values()))

    def for_type(self, request: m.TopicsForTypeRequest) -> m.TopicsForTypeResponse:
        found = (name for name, ros_type in self._visible().items() if same_type(ros_type, request.type))
        return m.TopicsForTypeResponse(topics=tuple(found))

    def type_of(self, request: m.TopicTypeRequest) -> m.TopicTypeResponse:
        found = self._graph.get_message_type(_absolute(request.topic))
        return m.TopicTypeResponse(type=found.ros_type if found else "")

    def all_with_text(self, _request: m.TopicsAndRawTypesRequest) -> m.TopicsAndRawTypesResponse:
        topics = self._visible()
        texts = [definition_text(found) for name in topics if (found := self._graph.get_message_type(name))]
        return m.TopicsAndRawTypesResponse(
            topics=tuple(topics), types=tuple(topics.values()), typedefs_full_text=tuple(texts)
        )

    def details(self, request: m.MessageDetailsRequest) -> m.MessageDetailsResponse:
        return m.MessageDetailsResponse(typedefs=typedefs_of(find_message_type(self._graph, request.type)))

    def publishers(self, request: m.PublishersRequest) -> m.PublishersResponse:
        return m.PublishersResponse(publishers=self._users(EntityKind.PUBLISHER, request.topic))

    def subscribers(self, request: m.SubscribersRequest) -> m.SubscribersResponse:
        return m.SubscribersResponse(subscribers=self._users(EntityKind.SUBSCRIPTION, request.topic))

    def _users(self, kind: EntityKind, topic: str) -> tuple[str, ...]:
        return _sorted(info.node for info in self._graph.get_endpoints(kind=kind, name=_absolute(topic)))

    def _visible(self) -> dict[str, str]:
        topics = self._graph.get_topic_names_and_types().items()
        return {name: ros_type for name, ros_type in topics if not is_hidden(name)}


class _Services:
    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.ServicesRequest) -> m.ServicesResponse:
        return m.ServicesResponse(services=tuple(self._visible()))

    def for_type(self, request: m.ServicesForTypeRequest) -> m.ServicesForTypeResponse:
        found = (name for name, ros_type in self._visible().items() if same_type(ros_type, request.type))
        return m.ServicesForTypeResponse(services=tuple(found))

    def type_of(self, request: m.ServiceTypeRequest) -> m.ServiceTypeResponse:
        return m.ServiceTypeResponse(type=self._graph.get_service_names_and_types().get(_absolute(request.service), ""))

    def request_details(self, request: m.ServiceRequestDetailsRequest) -> m.ServiceRequestDetailsResponse:
        found = find_service_type(self._graph, request.type)
        return m.ServiceRequestDetailsResponse(typedefs=typedefs_of(found.Request))

    def response_details(self, request: m.ServiceResponseDetailsRequest) -> m.ServiceResponseDetailsResponse:
        found = find_service_type(self._graph, request.type)
        return m.ServiceResponseDetailsResponse(typedefs=typedefs_of(found.Response))

    def node_of(self, request: m.ServiceNodeRequest) -> m.ServiceNodeResponse:
        found = self._graph.get_endpoints(kind=EntityKind.SERVICE, name=_absolute(request.service))
        return m.ServiceNodeResponse(node=found[0].node if found else "")

    def providers(self, request: m.ServiceProvidersRequest) -> m.ServiceProvidersResponse:
        served = self._graph.get_endpoints(kind=EntityKind.SERVICE)
        return m.ServiceProvidersResponse(
            providers=_sorted(info.node for info in served if same_type(info.ros_type, request.service))
        )

    def _visible(self) -> dict[str, str]:
        services = self._graph.get_service_names_and_types().items()
        return {name: ros_type for name, ros_type in services if not is_hidden(name)}


class _Nodes:
    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def all(self, _request: m.NodesRequest) -> m.NodesResponse:
        return m.NodesResponse(nodes=tuple(name for name in self._graph.get_node_names() if not is_hidden(name)))

    def details(self, request: m.NodeDetailsRequest) -> m.NodeDetailsResponse:
        ends = self._graph.get_endpoints(node=_absolute(request.node))
        return m.NodeDetailsResponse(
            subscribing=_sorted(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
            publishing=_sorted(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
            services=_sorted(info.name for info in ends if info.kind is EntityKind.SERVICE),
        )

    def action_servers(self, _request: m.GetActionServersRequest) -> m.GetActionServersResponse:
        topics = self._graph.get_topic_names_and_types()
        suffix = "/_action/status"  # every action server publishes this
        return m.GetActionServersResponse(
            action_servers=tuple(name.removesuffix(suffix) for name in topics if name.endswith(suffix))
        )

    def time(self, _request: m.GetTimeRequest) -> m.GetTimeResponse:
        now = Time.from_seconds(self._graph.clock.now())
        return m.GetTimeResponse(
            time=m.TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec)
        )

    def ros_version(self, _request: m.GetROSVersionRequest) -> m.GetROSVersionResponse:
        return m.GetROSVersionResponse(version=2, distro="homebot")


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


def _sorted(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(names)))
