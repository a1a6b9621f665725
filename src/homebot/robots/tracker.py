"""The tracker of robots: the node ``/robots``.

It publishes on ``/robots/poses`` the best that is known of each robot's place, and answers ``/robots/where``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Coroutine, Mapping
from functools import partial
from typing import Final

import anyio
from anyio.abc import TaskStatus

from homebot.config import UNNAMED
from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import ConfigError
from homebot.graph import Node, qos_profile_latched
from homebot.messages.builtin_interfaces import Time
from homebot.places import HousePlan, HouseRoom
from homebot.robots.evidence import TF_LIMIT, PoseEvidence
from homebot.robots.frames import RobotFrames
from homebot.robots.gateway_topics import GatewayTopics
from homebot.robots.house_rooms import NO_ROOMS, HouseRoomsReader
from homebot.robots.pose_topics import PoseTopics
from homebot.robots.robot import TrackedRobot
from homebot.robots.rooms import RobotRooms
from homebot.robots.sensors import follow_motion, read_pose, read_tags
from homebot.robots.settings import RobotSettings
from homebot.robots.vacuum import Vacuum
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["RobotTracker"]

UNSURE = "robots.unsure"
EXPIRED = "robots.expired"

_TF_ERROR: Final = 0.2
_LEAST_TF_ERROR: Final = 0.04
"""Metres by which a position by frames may be wrong where no covariance is stated, and at least. They are newer than
the last pose of AMCL, so they are taken to be a little better."""

_RENEWED: Final = 5.0
"""Least seconds, and at least its limit, after which a pose that only was received again is published again."""

_PACE: Final = 0.1
_MOVED: Final = 0.1
_TURNED: Final = 0.2
"""Least seconds, metres and radians from one published pose to the next."""


class RobotTracker:
    """The places of all robots, from all that is known of them.

    Args:
        node: Its node.
        owners: The robots, with their topics and frames.
        settings: The tables of those that have one.
        house: The plan of the house, until the directory is asked for it.

    Attributes:
        owners: The robots, with their topics and frames.
        settings: The table of each robot.
        rooms: The rooms of the house.
        frames: The frames of the robots.
    """

    def __init__(
        self,
        node: Node,
        owners: RobotOwners,
        settings: Mapping[str, RobotSettings] | None = None,
        house: HousePlan | None = None,
    ) -> None:
        self.owners = owners
        self.settings = {name: (settings or {}).get(name) or RobotSettings() for name in owners.names}
        self.rooms = RobotRooms(house or HousePlan(UNNAMED))
        self.frames = RobotFrames(owners)
        self._node = node
        self._clock = node.graph.clock
        self._robots = {name: TrackedRobot(name) for name in owners.names}
        self._published: dict[str, RobotPose] = {}
        self._changed = anyio.Event()
        self._poses = node.create_publisher(RobotPose, ROBOT_POSES, qos_profile_latched)
        node.create_service(WhereIsRobot, WHERE_IS_ROBOT, self.where)
        PoseTopics(self, node).open()
        self._house_rooms = HouseRoomsReader(node, self.rooms.house.home, self._set_house)
        self._works: list[Callable[[], Coroutine[object, object, None]]] = [self._house_rooms.run]
        self._read_others()

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Publish poses as they change, until cancelled."""
        async with anyio.create_task_group() as tasks:
            for work in self._works:
                tasks.start_soon(work)
            task_status.started()
            await self._publish_changes()

    async def _publish_changes(self) -> None:
        while True:
            now = self._clock.monotonic()
            self._changed = anyio.Event()
            next_change = min(self._publish_change(robot, now) for robot in self._robots.values())
            with anyio.move_on_after(None if math.isinf(next_change) else max(0.0, next_change - now)):
                await self._changed.wait()
            await anyio.sleep(_PACE)

    def _read_others(self) -> None:
        """Read the further sources that the tables name."""
        node, topics = self._node, GatewayTopics(self._node)
        sensors = {}
        for name, table in self.settings.items():
            if table.topic:
                topics.read(table.gateway, table.topic, partial(read_pose, self, node, name))
            if table.vacuum:
                vacuum = Vacuum(self, node, name, table, self._set_rooms)
                vacuum.read(topics)
                self._works.append(vacuum.run)
            if table.tag_reader:
                read_tags(self, node, name, table.tag_reader)
            sensors.update({key: name for one in table.motion_sensors for key in (one, fold(one))})
        if topics:
            self._works.append(topics.run)
        if sensors:
            self._works.append(partial(follow_motion, self, node, sensors))

    def _set_house(self, plan: HousePlan) -> None:
        try:
            self.rooms.set_house(plan)
        except ConfigError as exc:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of the house are not those of a map: {exc}")
        self._changed.set()

    def _set_rooms(self, robot: str, rooms: list[HouseRoom]) -> None:
        """Take the rooms on the map of *robot*; those that have a name of the owner become rooms of the house."""
        try:
            self.rooms.set_map(robot, rooms)
        except ConfigError as exc:
            self._node.log.warning(NO_ROOMS, message=f"the rooms on the map of {robot} are left out: {exc}")
            return
        self._changed.set()
        named = [one for one in rooms if not one.name.startswith(f"{robot} room ")]
        self._node.create_task(partial(self._house_rooms.add, named, self.rooms.house))

    def where(self, request: WhereIsRobotRequest) -> WhereIsRobotResponse:
        """Answer the service: where a robot is, or was, and how old that is."""
        by_name = {"robot": self.owners.sole, "": self.owners.sole} | {fold(one): one for one in self._robots}
        name = by_name.get(fold(request.robot)) or request.robot
        robot = self._robots.get(name)
        known = ", ".join(self.owners.names)
        if robot is None:
            hint = did_you_mean(name, self.owners.names, f"robots are {known}")
            problem = f"there is no robot {name[:100]!r}; {hint}" if name else f"say which robot: {known}"
            return WhereIsRobotResponse(success=False, message=problem, is_mistake=True)
        now = self._clock.monotonic()
        self._place_by_frames(name)
        evidence = robot.best(now)
        if evidence is None:
            return WhereIsRobotResponse(success=False, message=f"nothing has told yet where {name} is")
        pose = self._pose(robot, evidence, now)
        age = max(0.0, now - evidence.received_at)
        problem = "" if pose.counts else f"{name}'s pose is {age:.0f} s old (limit {pose.limit:g} s)"
        if evidence.has_ended:
            problem = f"{name} is no longer where it was {age:.0f} s ago, by {pose.source}"
        if pose.counts and robot.unsure_because:
            problem = f"{name} is not sure where it is: {robot.unsure_because}"
        return WhereIsRobotResponse(success=pose.counts, message=problem, pose=(pose,), age=age)

    def add(self, robot: str, evidence: PoseEvidence) -> None:
        """Take *evidence* of where *robot* is."""
        tracked = self._robots[robot]
        was = tracked.unsure_because
        tracked.add(evidence)
        self._report_unsure(tracked, was)
        self._changed.set()

    def add_room(self, robot: str, source: str, room: str, limit: float) -> None:
        """Take the statement of *source* that *robot* is in *room*, which counts for *limit* seconds."""
        now, error = self._clock.monotonic(), self.rooms.error_in(room)
        self.add(robot, PoseEvidence(source, now, limit, error, room=room))

    def add_life(self, robot: str) -> None:
        """Take a message of *robot* as a sign that it lives; its frames may have changed."""
        self._robots[robot].alive_at = self._clock.monotonic()
        self._changed.set()

    def make_unsure(self, robot: str, reason: str) -> None:
        """Doubt the poses of *robot* until some are consistent."""
        tracked = self._robots[robot]
        was = tracked.unsure_because
        tracked.make_unsure(reason)
        self._report_unsure(tracked, was)
        self._changed.set()

    def drop(self, robot: str, source: str) -> None:
        """End the evidence of *source* of where *robot* is."""
        self._robots[robot].drop(source)
        self._changed.set()

    def floor_of(self, robot: str) -> str:
        """Return the floor that *robot* is on; empty where that is not stated."""
        return self.rooms.floor_of(self.settings[robot].floor)

    def _place_by_frames(self, robot: str) -> None:
        found = self.frames.pose_of(robot, self.settings[robot].frames)
        if found is None:
            return
        position, received_at = found
        last = self._robots[robot].last_of("/tf")
        if last is not None and (last.received_at, last.position) == (received_at, position):
            return
        sigma, floor = self._robots[robot].sigma, self.floor_of(robot)
        error = _TF_ERROR if sigma is None else max(_LEAST_TF_ERROR, sigma)
        self.add(robot, PoseEvidence("/tf", received_at, TF_LIMIT, error, position, "", floor, sigma=sigma or 0.0))

    def _publish_change(self, robot: TrackedRobot, now: float) -> float:
        """Publish where *robot* is if that changed; return when it may change next by itself."""
        self._place_by_frames(robot.name)
        evidence = robot.best(now)
        if evidence is not None:
            pose, before = self._pose(robot, evidence, now), self._published.get(robot.name)
            if before is None or _differs(pose, before):
                self._published[robot.name] = pose
                self._poses.publish(pose)
                if not pose.counts:
                    self._node.log.info(
                        EXPIRED,
                        message=f"{robot.name}'s pose no longer counts (limit {pose.limit:g} s)",
                        robot=robot.name,
                    )
        return robot.next_change(now)

    def _pose(self, robot: TrackedRobot, evidence: PoseEvidence, now: float) -> RobotPose:
        """Return *evidence* as a message."""
        at, room, is_nearest = evidence.position, evidence.room, evidence.is_nearest_room
        if at is not None and not room:
            before = self._published.get(robot.name)
            found = self.rooms.room_at(at, evidence.floor, before.room if before is not None else "")
            room, is_nearest = (found.room, found.is_nearest) if found is not None else ("", False)
        x, y, yaw = at or (0.0, 0.0, 0.0)
        return RobotPose(
            robot=robot.name,
            room=room,
            is_nearest_room=is_nearest,
            floor=evidence.floor,
            has_position=at is not None,
            x=x,
            y=y,
            yaw=yaw,
            error=evidence.error,
            source=evidence.source,
            received_at=Time.from_seconds(self._clock.now() - max(0.0, now - evidence.received_at)),
            limit=evidence.limit,
            counts=evidence.expires_at(robot.alive_at) > now,
            is_sure=not robot.unsure_because,
        )

    def _report_unsure(self, robot: TrackedRobot, was: str) -> None:
        if robot.unsure_because and not was:
            text = f"{robot.name} is not sure where it is: {robot.unsure_because}"
            self._node.log.warning(UNSURE, message=text, robot=robot.name)


def _differs(pose: RobotPose, before: RobotPose) -> bool:
    """Return whether *pose* is worth a message after *before*."""
    words = ("room", "is_nearest_room", "floor", "has_position", "source", "limit", "counts", "is_sure")
    if any(getattr(pose, word) != getattr(before, word) for word in words):
        return True
    if pose.received_at.to_seconds() - before.received_at.to_seconds() >= max(_RENEWED, pose.limit):
        return True
    moved, turned = math.dist((pose.x, pose.y), (before.x, before.y)), abs(pose.yaw - before.yaw)
    has_new_error = not 0.5 < pose.error / (before.error or 1) < 2
    return moved >= _MOVED or min(turned, math.tau - turned) >= _TURNED or has_new_error
