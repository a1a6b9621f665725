"""The services of ``/rosapi``; answers are those of the original, with ROS 2's full type names.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi/scripts/rosapi_node`` and ``rosapi/src/rosapi``.
"""

from __future__ import annotations

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.rosapi import endpoints, nodes, parameters, services, topics
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
        of_topics, of_services = topics.TopicDirectory(graph), services.ServiceDirectory(graph)
        of_nodes, of_parameters = nodes.NodeDirectory(graph), parameters.GraphParameters(graph)
        offer = node.create_service
        offer(topics.Topics, "/rosapi/topics", of_topics.all)
        offer(topics.TopicsForType, "/rosapi/topics_for_type", of_topics.for_type)
        offer(topics.TopicType, "/rosapi/topic_type", of_topics.type_of)
        offer(topics.TopicsAndRawTypes, "/rosapi/topics_and_raw_types", of_topics.all_with_text)
        offer(topics.MessageDetails, "/rosapi/message_details", of_topics.details)
        offer(topics.Publishers, "/rosapi/publishers", of_topics.publishers)
        offer(topics.Subscribers, "/rosapi/subscribers", of_topics.subscribers)
        offer(services.Services, "/rosapi/services", of_services.all)
        offer(services.ServicesForType, "/rosapi/services_for_type", of_services.for_type)
        offer(services.ServiceTypeOf, "/rosapi/service_type", of_services.type_of)
        offer(services.ServiceRequestDetails, "/rosapi/service_request_details", of_services.request_details)
        offer(services.ServiceResponseDetails, "/rosapi/service_response_details", of_services.response_details)
        offer(services.ServiceNode, "/rosapi/service_node", of_services.node_of)
        offer(services.ServiceProviders, "/rosapi/service_providers", of_services.providers)
        offer(nodes.Nodes, "/rosapi/nodes", of_nodes.all)
        offer(nodes.NodeDetails, "/rosapi/node_details", of_nodes.details)
        offer(nodes.GetActionServers, "/rosapi/action_servers", of_nodes.action_servers)
        offer(nodes.GetTime, "/rosapi/get_time", of_nodes.time)
        offer(nodes.GetROSVersion, "/rosapi/get_ros_version", of_nodes.ros_version)
        offer(parameters.GetParam, "/rosapi/get_param", of_parameters.get)
        offer(parameters.SetParam, "/rosapi/set_param", of_parameters.set)
        offer(parameters.DeleteParam, "/rosapi/delete_param", of_parameters.delete)
        offer(parameters.HasParam, "/rosapi/has_param", of_parameters.has)
        offer(parameters.GetParamNames, "/rosapi/get_param_names", of_parameters.names)
        offer(endpoints.FindEndpoints, "/rosapi/endpoints", lambda request: endpoints.find_endpoints(graph, request))

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled; the services are there from the start."""
        task_status.started()
        await anyio.sleep_forever()
