"""The services of ``/rosapi``; answers are those of the original, with ROS 2's full type names.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi/scripts/rosapi_node`` and ``rosapi/src/rosapi``.
"""

from __future__ import annotations

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.rosapi import node_messages, parameter_messages, service_messages, topic_messages
from homebot.bridges.rosapi.endpoint_messages import FindEndpoints
from homebot.bridges.rosapi.endpoints import find_endpoints
from homebot.bridges.rosapi.nodes import NodeDirectory
from homebot.bridges.rosapi.parameters import GraphParameters
from homebot.bridges.rosapi.services import ServiceDirectory
from homebot.bridges.rosapi.topics import TopicDirectory
from homebot.graph import Node

__all__ = ["RosApi"]


class RosApi:
    """Offers the rosapi services on *node*; they go with it.

    Names that begin with an underscore are hidden, as in ROS; ``/rosapi/endpoints``, which is ours, shows them too.

    Args:
        node: The node that serves; its name should be ``rosapi``, though the services have that name in any case.
    """

    def __init__(self, node: Node) -> None:
        graph = node.graph
        topics, services, nodes = TopicDirectory(graph), ServiceDirectory(graph), NodeDirectory(graph)
        parameters = GraphParameters(graph)
        node.create_service(topic_messages.Topics, "/rosapi/topics", topics.all)
        node.create_service(topic_messages.TopicsForType, "/rosapi/topics_for_type", topics.for_type)
        node.create_service(topic_messages.TopicType, "/rosapi/topic_type", topics.type_of)
        node.create_service(topic_messages.TopicsAndRawTypes, "/rosapi/topics_and_raw_types", topics.all_with_text)
        node.create_service(topic_messages.MessageDetails, "/rosapi/message_details", topics.details)
        node.create_service(topic_messages.Publishers, "/rosapi/publishers", topics.publishers)
        node.create_service(topic_messages.Subscribers, "/rosapi/subscribers", topics.subscribers)
        node.create_service(service_messages.Services, "/rosapi/services", services.all)
        node.create_service(service_messages.ServicesForType, "/rosapi/services_for_type", services.for_type)
        node.create_service(service_messages.ServiceTypeOf, "/rosapi/service_type", services.type_of)
        node.create_service(
            service_messages.ServiceRequestDetails, "/rosapi/service_request_details", services.request_details
        )
        node.create_service(
            service_messages.ServiceResponseDetails, "/rosapi/service_response_details", services.response_details
        )
        node.create_service(service_messages.ServiceNode, "/rosapi/service_node", services.node_of)
        node.create_service(service_messages.ServiceProviders, "/rosapi/service_providers", services.providers)
        node.create_service(node_messages.Nodes, "/rosapi/nodes", nodes.all)
        node.create_service(node_messages.NodeDetails, "/rosapi/node_details", nodes.details)
        node.create_service(node_messages.GetActionServers, "/rosapi/action_servers", nodes.action_servers)
        node.create_service(node_messages.GetTime, "/rosapi/get_time", nodes.time)
        node.create_service(node_messages.GetROSVersion, "/rosapi/get_ros_version", nodes.ros_version)
        node.create_service(parameter_messages.GetParam, "/rosapi/get_param", parameters.get)
        node.create_service(parameter_messages.SetParam, "/rosapi/set_param", parameters.set)
        node.create_service(parameter_messages.DeleteParam, "/rosapi/delete_param", parameters.delete)
        node.create_service(parameter_messages.HasParam, "/rosapi/has_param", parameters.has)
        node.create_service(parameter_messages.GetParamNames, "/rosapi/get_param_names", parameters.names)
        node.create_service(FindEndpoints, "/rosapi/endpoints", lambda request: find_endpoints(graph, request))

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled; the services are there from the start."""
        task_status.started()
        await anyio.sleep_forever()
