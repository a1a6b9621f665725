"""The actions of a simulated house's robot, as in Nav2: driving to a pose, and docking."""

from collections.abc import Callable
from typing import Any, Final, TypeAlias, final

import anyio

from homebot.graph.actions import ActionServer, Preemption, ServerGoal
from homebot.house.ros_robot import RosRobot, ros_pose
from homebot.messages.builtin_interfaces import Duration
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.places.plan import Point

_EVERY: Final = 0.2
"""Seconds between feedback messages."""

_RESERVED_S: Final = 900.0
"""Seconds of the house after a drive in which its errands do not send the robot away: a goal has further steps."""

_NOT_REACHED: Final = 207
_NO_DOCK: Final = 901
_NOT_STAGED: Final = 903
"""Nav2's codes for an unreachable goal, an unknown dock, and one that was not reached."""

_NAVIGATE: Final = "/navigate_to_pose"
_DOCK: Final = "/dock_robot"

_Goal: TypeAlias = ServerGoal[Any, Any, Any]

_STAGING: Final = 1


_Publish: TypeAlias = Callable[[Duration, float, float], None]
"""Publishes the time since the start, the distance left and the speed."""


@final
class RobotActions:
    """Serves ``/navigate_to_pose`` and ``/dock_robot``; a new goal of either ends the last one."""

    def __init__(self, robot: RosRobot) -> None:
        self._robot = robot
        self._clock = robot.node.graph.clock
        self._last_action = ""
        self._navigate = find_action("nav2_msgs/action/NavigateToPose")
        self._dock = find_action("nav2_msgs/action/DockRobot")
        ActionServer(robot.node, self._navigate, _NAVIGATE, self._drive, preemption=Preemption.ABORT)
        ActionServer(robot.node, self._dock, _DOCK, self._return, preemption=Preemption.ABORT)

    async def _drive(self, goal: _Goal) -> None:
        """Drive to the pose of *goal*, in the frame ``map``."""
        target = goal.request.pose

        def publish(spent: Duration, metres: float, speed: float) -> None:
            fields = {
                "current_pose": PoseStamped(header=self._robot.header("map"), pose=ros_pose(self._robot.read().pose())),
                "navigation_time": spent,
                "estimated_time_remaining": Duration.from_seconds(metres / speed),
                "distance_remaining": metres,
            }
            goal.publish_feedback(_message(self._navigate.Feedback, fields))

        def result(problem: str) -> Message:
            code = _NOT_REACHED if problem else 0
            return _message(self._navigate.Result, {"error_code": code, "error_msg": problem})

        if target.header.frame_id.removeprefix("/") not in {"", "map"}:
            goal.abort(result(f"the frame {target.header.frame_id[:100]!r} is not map"))
        else:
            await self._reach(goal, _NAVIGATE, (target.pose.position.x, target.pose.position.y), publish, result)

    async def _return(self, goal: _Goal) -> None:
        """Return to the dock, which is called ``dock`` or nothing."""

        def publish(spent: Duration, _metres: float, _speed: float) -> None:
            goal.publish_feedback(_message(self._dock.Feedback, {"state": _STAGING, "docking_time": spent}))

        def result(problem: str, code: int = _NOT_STAGED) -> Message:
            fields = {"success": not problem, "error_code": code if problem else 0, "error_msg": problem}
            return _message(self._dock.Result, fields)

        if goal.request.use_dock_id and goal.request.dock_id not in {"", "dock"}:
            problem = f"there is no dock {goal.request.dock_id[:100]!r}; the only one is dock"
            goal.abort(result(problem, _NO_DOCK))
        else:
            await self._reach(goal, _DOCK, self._robot.dock[:2], publish, result)

    async def _reach(
        self, goal: _Goal, action: str, point: Point, publish: _Publish, result: Callable[[str], Message]
    ) -> None:
        """Drive to *point*, publish the progress, and end *goal* with the *result* for the problem, if any."""
        robot, began, (x, y) = self._robot, self._clock.monotonic(), point
        if not robot.read().knows(f"go {x!r},{y!r}"):
            goal.abort(result(f"no room is at {x:g}, {y:g}, or no doors lead to it"))
            return
        self._last_action = action
        robot.command(f"go {x!r},{y!r}")
        try:
            while (now := robot.read()).drives and now.heads_for(point):
                now.reserved_until = now.now + _RESERVED_S
                publish(Duration.from_seconds(self._clock.monotonic() - began), now.metres_left(), now.speed)
                await anyio.sleep(_EVERY)
        finally:
            problem = self._problem(goal, action, point)
            if (now := robot.read()).drives and now.heads_for(point):
                robot.command("stop")
            if problem and goal.is_cancel_requested:
                goal.canceled(result(problem).model_copy(update={"error_code": 0}))
            else:
                (goal.abort if problem else goal.succeed)(result(problem))

    def _problem(self, goal: _Goal, action: str, point: Point) -> str:
        """Return why a goal ends before the robot is at its *point*; empty if it is there, even if just cancelled."""
        now = self._robot.read()
        if goal.is_preempted:
            return f"another goal of {action} replaced it"
        if now.heads_for(point) and not now.drives:
            return ""
        if goal.is_cancel_requested:
            return "its client cancelled it"
        by = now.last_sender if self._last_action == action else f"a goal of {self._last_action}"
        return f"the robot was stopped or sent elsewhere by {by or 'itself'}"


def _message(message_type: type[Message], values: dict[str, object]) -> Message:
    message: Message = zero_message(message_type)
    return message.model_copy(update=values)
