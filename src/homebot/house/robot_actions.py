"""The actions of a simulated house's robot, as Nav2 has them: to drive to a pose, and to dock."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, final

import anyio

from homebot.graph import Node
from homebot.graph.actions import ActionServer, Preemption, ServerGoal
from homebot.house.ros_robot import RosRobot, ros_pose
from homebot.messages.builtin_interfaces import Duration
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.messages.std_msgs.header import Header

__all__ = ["RobotActions"]

_EVERY: Final = 0.2
"""Seconds from one feedback to the next."""

_NOT_REACHED: Final = 207
_NO_DOCK: Final = 901
"""Nav2's codes for a goal that cannot be reached, and for a dock that is unknown."""

_STAGING: Final = 1
_DOCK: Final = "dock"


@final
class RobotActions:
    """Serves ``/navigate_to_pose`` and ``/dock_robot``; a new goal to drive aborts the one before.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RosRobot) -> None:
        self._robot = robot
        self._clock = robot.node.graph.clock
        self._navigate = find_action("nav2_msgs/action/NavigateToPose")
        self._dock = find_action("nav2_msgs/action/DockRobot")
        node: Node = robot.node
        ActionServer(node, self._navigate, "/navigate_to_pose", self._drive, preemption=Preemption.ABORT)
        ActionServer(node, self._dock, "/dock_robot", self._return, preemption=Preemption.ABORT)

    async def _drive(self, goal: ServerGoal[Any, Any, Any]) -> Message:
        """Drive to the pose of *goal*, in the frame ``map``."""
        target, began = goal.request.pose, self._clock.monotonic()
        x, y = target.pose.position.x, target.pose.position.y

        def publish(metres: float, speed: float) -> None:
            seconds = self._clock.monotonic() - began
            pose = PoseStamped(
                header=Header(stamp=self._robot.stamp(), frame_id="map"), pose=ros_pose(self._robot.read().pose())
            )
            known = {
                "current_pose": pose,
                "navigation_time": _duration(seconds),
                "estimated_time_remaining": _duration(metres / speed),
                "distance_remaining": metres,
            }
            goal.publish_feedback(_message(self._navigate.Feedback, known))

        problem = ""
        if target.header.frame_id.removeprefix("/") not in {"", "map"}:
            problem = f"the frame {target.header.frame_id[:100]!r} is not map"
        elif not await self._reach(x, y, publish):
            problem = f"no room is at {x:g}, {y:g}, or no doors lead to it"
        if problem:
            goal.abort()
            return _message(self._navigate.Result, {"error_code": _NOT_REACHED, "error_msg": problem})
        goal.succeed()
        return _message(self._navigate.Result, {})

    async def _return(self, goal: ServerGoal[Any, Any, Any]) -> Message:
        """Return to the dock, which is called ``dock`` or nothing."""
        began, request = self._clock.monotonic(), goal.request

        def publish(_metres: float, _speed: float) -> None:
            known = {"state": _STAGING, "docking_time": _duration(self._clock.monotonic() - began)}
            goal.publish_feedback(_message(self._dock.Feedback, known))

        is_known = not request.use_dock_id or request.dock_id in {"", _DOCK}
        dock = self._robot.dock
        is_reached = is_known and await self._reach(dock.x, dock.y, publish)
        if is_reached:
            goal.succeed()
        else:
            goal.abort()
        return _message(self._dock.Result, {"success": is_reached, "error_code": 0 if is_reached else _NO_DOCK})

    async def _reach(self, x: float, y: float, publish: Callable[[float, float], None]) -> bool:
        """Drive to a point, and report the metres left and the speed; stop where the goal ends before."""
        robot = self._robot
        if not robot.read().knows(f"go {x!r},{y!r}"):
            return False
        robot.command(f"go {x!r},{y!r}")
        try:
            while (now := robot.read()).drives:
                publish(now.metres_left(), now.speed)
                await anyio.sleep(_EVERY)
        except anyio.get_cancelled_exc_class():
            robot.command("stop")
            raise
        return robot.read().pose()[:2] == (x, y)


def _duration(seconds: float) -> Duration:
    return Duration(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))


def _message(message_type: type[Message], values: Mapping[str, object]) -> Message:
    message: Message = zero_message(message_type)
    return message.model_copy(update=values)
