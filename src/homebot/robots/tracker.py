"""The tracker of robots: the node ``/robots``.

It publishes the best known pose of each robot on ``/robots/poses``, and serves ``/robots/where``.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

import anyio
from anyio.abc import TaskStatus

from homebot.devices.devices import Devices
from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.robot_owners import RobotOwners
from homebot.graph import Node, qos_profile_latched
from homebot.messages.builtin_interfaces import Time
from homebot.places import HousePlan
from homebot.places.floor_plan import FloorPlan
from homebot.robots.device_drive import DeviceDrive
from homebot.robots.pose_topics import PACE, PoseTopics
from homebot.robots.robot import TrackedRobot
from homebot.robots.sensors import follow_motion, read_poses, read_tags
from homebot.robots.settings import RobotSettings
from homebot.robots.vacuum import Vacuum
from homebot.support.folding import fold
from homebot.support.names import find_name, no_such

UNSURE = "robots.unsure"
EXPIRED = "robots.expired"

_RENEWED: Final = 5.0
"""The shortest time in seconds, and at least its limit, after which an unchanged pose is published again."""

_MOVED: Final = 0.1
_TURNED: Final = 0.2
"""The smallest difference between two published poses, in metres and radians."""


class RobotTracker:
    """The poses of all robots, from all sources.

    Args:
        house: Returns the current plan of the house.
    """

    def __init__(
        self,
        node: Node,
        owners: RobotOwners,
        house: Callable[[], HousePlan],
        settings: Mapping[str, RobotSettings] | None = None,
    ) -> None:
        self._node, self._owners, self._house = node, owners, house
        self._changed, now = anyio.Event(), node.graph.steady_now
        self._robots = {
            name: TrackedRobot(name, (settings or {}).get(name) or RobotSettings(), now, self._wake)
            for name in owners.names
        }
        self._published: dict[str, RobotPose] = {}
        self._poses = node.create_publisher(RobotPose, ROBOT_POSES, qos_profile_latched)
        self._topics = PoseTopics(node, owners, self._robots, self._wake)
        node.create_service(WhereIsRobot, WHERE_IS_ROBOT, self._where)
        devices = Devices(node)
        self._drives: dict[str, DeviceDrive] = {}
        for robot in self._robots.values():
            if robot.settings.topic:
                node.create_task(partial(read_poses, node, devices, robot))
                self._drives[robot.name] = DeviceDrive(node, devices, robot, self._house)
                node.create_task(self._drives[robot.name].run)
            if robot.settings.vacuum:
                node.create_task(Vacuum(node, devices, robot, self._house).run)
            if robot.settings.tag_reader:
                read_tags(node, robot)
        if any(robot.settings.motion_sensors for robot in self._robots.values()):
            node.create_task(partial(follow_motion, devices, tuple(self._robots.values())))

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Publish poses as they change, until cancelled."""
        task_status.started()
        while True:
            self._changed = anyio.Event()
            self._topics.read()
            seconds = min(map(self._publish_change, self._robots.values()))
            with anyio.move_on_after(None if math.isinf(seconds) else seconds):
                await self._changed.wait()
                await anyio.sleep(PACE)

    def _wake(self) -> None:
        self._changed.set()

    def _where(self, request: WhereIsRobotRequest) -> WhereIsRobotResponse:
        self._topics.read()
        is_any = fold(request.robot) in {"robot", ""}
        present = [one.name for one in self._robots.values() if one.has_lived or one.name not in self._owners.guests]
        sole = self._owners.sole if len(present) < 2 else ""
        name = find_name(request.robot, self._robots) or (is_any and sole) or request.robot
        robot = self._robots.get(name)
        if robot is None:
            which = f"say which robot: {', '.join(present or self._owners.names)}"
            problem = no_such("robot", name[:100], self._owners.names) if name else which
            return WhereIsRobotResponse(success=False, message=problem, is_mistake=True)
        found = WhereIsRobotResponse(
            success=False, robot=name, is_sole=name == self._owners.sole, is_gone=self._is_gone(robot)
        )
        if (best := robot.best()) is None:
            problem = f"the position of {name} is not known yet"
            return found.model_copy(update={"message": self._with_refusal(problem, name)})
        pose, received_at = self._completed(robot, best), best.received_at.to_seconds()
        age = max(0.0, robot.now() - received_at)
        problem = "" if pose.is_sure else f"{name} is not sure where it is: {robot.unsure_because}"
        if not pose.counts:
            problem = self._with_refusal(
                f"{name}'s pose is {age:.0f} s old (limit {pose.limit:g} s)", name, received_at
            )
        if not pose.limit:
            problem = f"{name} is no longer where it was {age:.0f} s ago, by {pose.source}"
        return found.model_copy(update={"success": pose.counts, "message": problem, "pose": (pose,), "age": age})

    def _is_gone(self, robot: TrackedRobot) -> bool:
        drive = self._drives.get(robot.name)
        if drive is not None and drive.reachable is not None:
            return not drive.reachable
        return robot.now() - robot.alive_at > robot.settings.limit and self._topics.are_silenced(robot.name)

    def _with_refusal(self, problem: str, robot: str, since: float = -math.inf) -> str:
        return "; ".join(filter(None, (problem, self._topics.refusal(robot, since))))

    def _publish_change(self, robot: TrackedRobot) -> float:
        """Publish the pose of *robot* if it changed; return the seconds until it may change by itself."""
        best, before = robot.best(), self._published.get(robot.name)
        if best is not None:
            pose = self._completed(robot, best)
            if before is None or _differs(pose, before):
                self._published[robot.name] = pose
                self._poses.publish(pose)
                if not pose.counts:
                    because = f"limit {pose.limit:g} s" if pose.limit else f"by {pose.source}"
                    text = f"{robot.name}'s pose no longer counts ({because})"
                    self._node.log.info(EXPIRED, message=text, robot=robot.name)
                if not pose.is_sure and (before is None or before.is_sure):
                    text = f"{robot.name} is not sure where it is: {robot.unsure_because}"
                    self._node.log.warning(UNSURE, message=text, robot=robot.name)
        return robot.next_change()

    def _completed(self, robot: TrackedRobot, pose: RobotPose) -> RobotPose:
        """Return *pose* with its room in the house and the status of the robot."""
        house, before = self._house(), self._published.get(robot.name)
        plan = FloorPlan.of(house)
        floor = plan.level(pose.floor or robot.settings.floor)
        received_at = self._node.graph.clock.now() - (robot.now() - pose.received_at.to_seconds())
        known: dict[str, object] = {"floor": floor, "is_sure": robot.is_sure(pose)}
        known["received_at"] = Time.from_seconds(received_at)
        if not pose.has_position:
            room = house.locate(pose.room)[0] or pose.room
            centre = plan.centre_of(room)
            known.update(room=room, error=pose.error if centre is None else centre.error)
        elif not pose.room and (at := plan.room_at(pose.x, pose.y, floor, "" if before is None else before.room)):
            known.update(room=at.room, is_nearest_room=at.is_nearest)
        known["counts"] = counts = robot.expires_at(pose) > robot.now()
        stated = pose.model_copy(update=known)
        if counts and (goal := robot.goal()) is not None:
            at = None if isinstance(goal, str) else plan.room_at(*goal, floor)
            rooms = (stated.room, goal if isinstance(goal, str) else "" if at is None else at.room)
            stated = stated.model_copy(update={"way": tuple(dict.fromkeys(filter(None, rooms)))})
        return stated


def _differs(pose: RobotPose, before: RobotPose) -> bool:
    """Return whether *pose* differs enough from *before* to be published."""
    words = ("room", "is_nearest_room", "floor", "has_position", "source", "limit", "counts", "is_sure", "way")
    if any(getattr(pose, word) != getattr(before, word) for word in words):
        return True
    if pose.received_at.to_seconds() - before.received_at.to_seconds() >= max(_RENEWED, pose.limit):
        return True
    moved, turned = math.dist((pose.x, pose.y), (before.x, before.y)), abs(pose.yaw - before.yaw)
    has_new_error = not 0.5 < pose.error / (before.error or 1) < 2
    return moved >= _MOVED or min(turned, math.tau - turned) >= _TURNED or has_new_error
