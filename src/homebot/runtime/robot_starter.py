"""The tracker of robots, started if there is a robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from anyio.abc import TaskStatus

from homebot.devices.names import POSE_TOPICS
from homebot.graph import EntityKind, Graph, Node
from homebot.places import HousePlan
from homebot.runtime.plan import Plan
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.graph.endpoint import EndpointInfo


async def track_robots(
    graph: Graph, plan: Plan, rooms: Callable[[], HousePlan], *, task_status: TaskStatus[None]
) -> None:
    """Track robots until cancelled; if none is configured, start when the first one publishes its pose."""
    if not plan.names_robots:
        task_status.started()
        await _first_pose_topic(graph, plan)
    from homebot.robots.tracker import RobotTracker  # noqa: PLC0415 - few houses have a robot

    async with Node(graph, "robots") as node:
        tracker = RobotTracker(node, plan.robot_owners(), rooms, plan.robots)
        await run_as(node.full_name, partial(tracker.serve, task_status=task_status))


async def _first_pose_topic(graph: Graph, plan: Plan) -> None:
    def has_pose(entity: EndpointInfo) -> bool:
        if entity.kind is not EntityKind.PUBLISHER or entity.name.rpartition("/")[2] not in POSE_TOPICS:
            return False
        return plan.robot_owners().of_topic(entity.name) is not None

    with graph.watch() as changes:
        if any(map(has_pose, graph.get_endpoints(kind=EntityKind.PUBLISHER))):
            return
        async for change in changes:
            if has_pose(change.entity):
                return
