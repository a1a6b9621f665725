"""Drives of robots, by their action ``navigate_to_pose`` or ``dock_robot``, as in Nav2."""

from contextlib import closing
from typing import Final

import anyio

from homebot.devices.names import GET_PLACES, WHERE_IS_ROBOT
from homebot.devices.places_messages import GetPlaces, RoomInfo
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.errors import LinkError, UsageError
from homebot.graph import EntityKind, Node
from homebot.graph.actions import ActionClient
from homebot.messages import Time
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.messages.std_msgs import Header
from homebot.places.polygon import Polygon
from homebot.support.names import resolve_name
from homebot.words.steps import SendRobot
from homebot.words.triggers import RobotArrival

_MAX_DRIVE_S: Final = 900.0
"""Seconds after which a robot that is still on its way is called off."""


async def drive(node: Node, step: SendRobot) -> None:
    """Send the robot, and return when it is there. Cancelling the caller cancels the drive.

    Raises:
        HomebotError: There is no such robot or room, or it did not arrive.
    """
    action_type = find_action(f"nav2_msgs/action/{'DockRobot' if step.is_to_dock else 'NavigateToPose'}")
    action = await _action_of(node, step.robot, "dock_robot" if step.is_to_dock else "navigate_to_pose")
    goal_type: type[Message] = action_type.Goal
    goal: Message = zero_message(goal_type)
    if not step.is_to_dock:
        goal = goal.model_copy(update={"pose": await _pose_in(node, step.room)})
    try:
        with closing(ActionClient(node, action_type, action)) as client, anyio.fail_after(_MAX_DRIVE_S):
            await client.perform(goal)
    except TimeoutError:
        raise LinkError(f"it has not arrived in {_MAX_DRIVE_S / 60:.0f} minutes, and was called off") from None


async def check_move(node: Node, move: SendRobot | RobotArrival) -> None:
    """Check the preconditions of :func:`drive`, or of an arrival.

    Raises:
        HomebotError: There is no such robot, action or room now, or where the room lies is unknown.
    """
    match move:
        case SendRobot(is_to_dock=True):
            await _action_of(node, move.robot, "dock_robot")
            return
        case SendRobot():
            await _action_of(node, move.robot, "navigate_to_pose")
        case RobotArrival() if move.robot != "robot":  # which is any
            await _robot_called(node, move.robot)
    await _pose_in(node, move.room)


async def _robot_called(node: Node, robot: str) -> tuple[str, bool]:
    """Return the full name of *robot*, and whether names without a namespace are its.

    Raises:
        UsageError: There is no such robot.
    """
    with closing(node.create_client(WhereIsRobot, WHERE_IS_ROBOT)) as where:
        if not where.service_is_ready():
            return robot, robot == "robot"
        answer = await where.call(WhereIsRobotRequest(robot=robot))
        if answer.is_mistake:
            raise UsageError(answer.message)
        return answer.robot, answer.is_sole


async def _action_of(node: Node, robot: str, action: str) -> str:
    """Return the full name of an action of *robot*; that of a sole robot may have no namespace.

    Raises:
        UsageError: There is no such robot, or it has no such action now.
    """
    name, is_sole = await _robot_called(node, robot)
    offered = {endpoint.name for endpoint in node.graph.get_endpoints(kind=EntityKind.ACTION_SERVER)}
    names = [f"/{name}/{action}"] + ([f"/{action}"] if is_sole else [])
    for candidate in names:
        if candidate in offered:
            return candidate
    raise UsageError(
        f"no robot offers the action {' or '.join(names)}; `homebot service call /rosapi/action_servers` lists all"
    )


async def _pose_in(node: Node, room: str) -> PoseStamped:
    """Return a pose in the middle of *room*.

    Raises:
        UsageError: There is no such room, or its area is unknown.
    """
    with closing(node.create_client(GetPlaces, GET_PLACES)) as places:
        rooms = (await places.call(GetPlaces.Request())).rooms
    by_name = {info.name: info for info in rooms}
    if (area := _area_of(by_name[resolve_name("room", room, by_name)])) is None:
        raise UsageError(f"where {room} lies is unknown; import a floor plan: homebot places import FILE")
    x, y = area.nearest_inside(*area.centroid())
    header = Header(stamp=Time.from_seconds(node.graph.clock.now()), frame_id="map")
    pose = Pose(position=Point(x=x, y=y, z=0.0), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
    return PoseStamped(header=header, pose=pose)


def _area_of(room: RoomInfo) -> Polygon | None:
    """Return the largest area of *room*."""
    rings = [tuple(zip(area.x, area.y, strict=True)) for area in room.areas if not area.is_hole]
    return max(map(Polygon, rings), key=lambda polygon: polygon.area, default=None)
