"""Positions of identified devices, from the pose of the robot that saw them."""

from contextlib import closing
from math import cos, hypot, sin
from typing import Final

from homebot.devices.names import SEEN, TEACH_PLACE, WHERE_IS_ROBOT
from homebot.devices.places_messages import TeachPlace, TeachPlaceRequest
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.errors import ServiceError, UsageError
from homebot.features.identify.messages import IdentifyDeviceGoal
from homebot.graph import Node

_ERROR: Final = 0.1
"""Metres by which a sighting may be wrong, and metres for each metre of distance."""


async def check_robot(node: Node, robot: str) -> None:
    """Check the name of a *robot*.

    Raises:
        UsageError: Other robots have said where they are, but there is none of that name.
    """
    with closing(node.create_client(WhereIsRobot, WHERE_IS_ROBOT)) as where:
        if where.service_is_ready() and (answer := await where.call(WhereIsRobotRequest(robot=robot))).is_mistake:
            raise UsageError(answer.message)


async def save_seen_place(node: Node, goal: IdentifyDeviceGoal, device: str) -> tuple[str, str]:
    """Keep the position of *device*, seen in the direction and distance of *goal*; return it, and the problem if any.

    It counts only if neither the owner nor the device states one.
    """
    with (
        closing(node.create_client(WhereIsRobot, WHERE_IS_ROBOT)) as where,
        closing(node.create_client(TeachPlace, TEACH_PLACE)) as teach,
    ):
        try:
            answer = await where.call(WhereIsRobotRequest(robot=goal.robot))
            if not answer.success or not answer.pose or not answer.pose[0].has_position:
                return "", answer.message or f"the position of {goal.robot} is unknown"
            pose = answer.pose[0]
            x, y = (
                start + goal.distance * turn(pose.yaw + goal.bearing) for start, turn in ((pose.x, cos), (pose.y, sin))
            )
            floor, error = f",{pose.floor}" if pose.floor else "", hypot(pose.error, _ERROR * (1 + goal.distance))
            at = f"{x:.2f},{y:.2f}{floor} ±{error:.2f} m"
            taught = await teach.call(TeachPlaceRequest(device=device, gateway=SEEN, at=at))
        except ServiceError as exc:
            return "", str(exc)
    return (at, "") if taught.success else ("", taught.message)
