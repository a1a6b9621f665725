"""The services of ``/rosapi``; answers are those of the original, with ROS 2's full type names.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi/scripts/rosapi_node`` and ``rosapi/src/rosapi``.
"""

from __future__ import annotations

from functools import partial

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.rosapi.endpoints import FindEndpoints, find_endpoints
from homebot.bridges.rosapi.services import SERVICES
from homebot.graph import Node

__all__ = ["RosApi"]


class RosApi:
    """Offers the rosapi services on *node*; they go with it.

    Names that begin with an underscore are hidden, as in ROS; ``/rosapi/endpoints``, which is ours, shows them too.

    Args:
        node: The node that serves; its name should be ``rosapi``, though the services have that name in any case.
    """

    def __init__(self, node: Node) -> None:
        for service in SERVICES:
            service.serve(node)
        node.create_service(FindEndpoints, "/rosapi/endpoints", partial(find_endpoints, node.graph))

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled; the services are there from the start."""
        task_status.started()
        await anyio.sleep_forever()
