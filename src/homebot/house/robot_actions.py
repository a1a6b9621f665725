"""The actions of a simulated house's robot, as in Nav2: driving to a pose, and docking."""

from collections.abc import Callable
from typing import Any, Final, final

import anyio

from homebot.graph.actions import ActionServer, Preemption, ServerGoal
from homebot.house.ros_robot import RosRobot, ros_pose
from homebot.messages.builtin_interfaces import Duration
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message

__all__ = ["RobotActions"]

_EVERY: Final = 0.2
"""Seconds between feedback messages."""

_NOT_REACHED: Final = 207
_NO_DOCK: Final = 901
"""Nav2's codes for an unreachable goal and an unknown dock."""

_STAGING: Final = 1


@final
class RobotActions:
    """Serves ``/navigate_to_pose`` and ``/dock_robot``; a new goal to drive aborts the last one."""

    def __init__(self, robot: RosRobot) -> None:
        self._robot = robot
        self._clock = robot.node.graph.clock
        self._navigate = find_action("nav2_msgs/action/NavigateToPose")
        self._dock = find_action("nav2_msgs/action/DockRobot")
        ActionServer(robot.node, self._navigate, "/navigate_to_pose", self._drive, preemption=Preemption.ABORT)
        ActionServer(robot.node, self._dock, "/dock_robot", self._return, preemption=Preemption.ABORT)

    async def _drive(self, goal: ServerGoal[Any, Any, Any]) -> Message:
        """Drive to the pose of *goal*, in the frame ``map``."""
        target = goal.request.pose
        x, y = target.pose.position.x, target.pose.position.y

        def publish(spent: Duration, metres: float, speed: float) -> None:
            fields = {
                "current_pose": PoseStamped(header=self._robot.header("map"), pose=ros_pose(self._robot.read().pose())),
                "navigation_time": spent,
                "estimated_time_remaining": Duration.from_seconds(metres / speed),
                "distance_remaining": metres,
            }
            goal.publish_feedback(_message(self._navigate.Feedback, fields))

        problem = ""
        if target.header.frame_id.removeprefix("/") not in {"", "map"}:
            problem = f"the frame {target.header.frame_id[:100]!r} is not map"
        elif not await self._reach(x, y, publish):
            problem = f"no room is at {x:g}, {y:g}, or no doors lead to it"
        (goal.abort if problem else goal.succeed)()
        code = _NOT_REACHED if problem else 0
        return _message(self._navigate.Result, {"error_code": code, "error_msg": problem})

    async def _return(self, goal: ServerGoal[Any, Any, Any]) -> Message:
        """Return to the dock, which is called ``dock`` or nothing."""

        def publish(spent: Duration, _metres: float, _speed: float) -> None:
            goal.publish_feedback(_message(self._dock.Feedback, {"state": _STAGING, "docking_time": spent}))

        dock = self._robot.dock
        problem = ""
        if goal.request.use_dock_id and goal.request.dock_id not in {"", "dock"}:
            problem = f"there is no dock {goal.request.dock_id[:100]!r}; the only one is dock"
        elif not await self._reach(dock.x, dock.y, publish):
            problem = "another goal moved the robot, or no doors lead to the dock"
        (goal.abort if problem else goal.succeed)()
        code = _NO_DOCK if problem else 0
        return _message(self._dock.Result, {"success": not problem, "error_code": code, "error_msg": problem})

    async def _reach(self, x: float, y: float, publish: Callable[[Duration, float, float], None]) -> bool:
        """Drive to a point; publish time, distance left and speed; stop if the goal ends earlier."""
        robot, began = self._robot, self._clock.monotonic()
        if not robot.read().knows(f"go {x!r},{y!r}"):
            return False
        robot.command(f"go {x!r},{y!r}")
        try:
            while (now := robot.read()).drives:
                publish(Duration.from_seconds(self._clock.monotonic() - began), now.metres_left(), now.speed)
                await anyio.sleep(_EVERY)
        except anyio.get_cancelled_exc_class():
            robot.command("stop")
            raise
        return robot.read().pose()[:2] == (x, y)


def _message(message_type: type[Message], values: dict[str, object]) -> Message:
    message: Message = zero_message(message_type)
    return message.model_copy(update=values)
