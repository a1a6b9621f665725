"""The rooms that need light because a robot is on its way in them, or to them."""

from typing import Final, final

from homebot.devices.names import ROBOT_POSES, ROBOTS_NODE
from homebot.devices.robot_messages import WAY_LIMIT_S, RobotPose
from homebot.graph import Node, qos_profile_latched
from homebot.support.bounded_map import BoundedMap
from homebot.support.folding import fold

_MAX_ROBOTS: Final = 100
"""Of further robots, the ones that were heard of first are forgotten."""


@final
class RobotWays:
    """The ways of all robots, as ``/robots/poses`` states them, while *node* lives."""

    def __init__(self, node: Node) -> None:
        self._clock = node.graph.clock
        self._poses: BoundedMap[str, tuple[RobotPose, float]] = BoundedMap(_MAX_ROBOTS)
        node.create_subscription(RobotPose, ROBOT_POSES, self._on_pose, qos_profile_latched, from_node=ROBOTS_NODE)

    def robot_in(self, room: str) -> str:
        """Return a robot that is on its way in *room*, or to it; empty for none. Case and accents do not matter."""
        since, wanted = self._clock.monotonic() - WAY_LIMIT_S, fold(room)
        known = self._poses.values()
        return next((pose.robot for pose, at in known if at > since and wanted in map(fold, pose.way)), "")

    def _on_pose(self, pose: RobotPose) -> None:
        self._poses[pose.robot] = pose, self._clock.monotonic()
