"""The topics on which robots state where they are.

Of each robot, and of a sole one without its name too, these are read:

====================  =============================================  =================================================
topic                 type                                           counts for
====================  =============================================  =================================================
``tf``, ``tf_static`` ``tf2_msgs/TFMessage``                         2 s since the oldest moving transform up to map
``amcl_pose``         ``geometry_msgs/PoseWithCovarianceStamped``    10 s since the robot's last sign of life, until
                                                                     its odometry moved 0.25 m
``pose``              ``geometry_msgs/PoseStamped``                  5 s (``limit``); without a name: ``/robot/pose``
``odom``              ``nav_msgs/Odometry``                          read with ``amcl_pose`` alone
``initialpose``       ``geometry_msgs/PoseWithCovarianceStamped``    makes it unsure, as a pose that jumps does
``room``              ``homebot/RobotRoom``                          10 min; without a name: ``/robot/room``
====================  =============================================  =================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, TypeVar

from homebot.devices.robot_messages import RobotRoom
from homebot.devices.robot_owners import DEFAULT_ROBOT
from homebot.errors import TypeMismatchError
from homebot.graph import DurabilityPolicy, EntityKind, Node, QoSProfile
from homebot.log import LogLimit
from homebot.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped
from homebot.messages.message import Message
from homebot.messages.nav_msgs import Odometry
from homebot.messages.std_msgs.header import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.places.transforms import TransformException
from homebot.robots.evidence import AMCL_LIMIT, ODOMETRY_MOVED, TAG_LIMIT, PoseEvidence
from homebot.robots.frames import MOST_AHEAD

if TYPE_CHECKING:
    from homebot.robots.tracker import RobotTracker

__all__ = ["PoseTopics"]

REFUSED = "robots.refused"

_POSE_ERROR: Final = 0.3
"""Metres by which a position may be wrong if its source states no covariance."""

_LEAST_ERROR: Final = 0.05
_LONGEST_ROOM: Final = 100
_DEPTH: Final = 100

MessageT = TypeVar("MessageT", bound=Message)


class PoseTopics:
    """Reads the pose topics of all robots into a tracker.

    Args:
        tracker: The tracker.
        node: Its node.
    """

    def __init__(self, tracker: RobotTracker, node: Node) -> None:
        self._tracker = tracker
        self._frames, self._owners = tracker.frames, tracker.owners
        self._node = node
        self._clock = node.graph.clock
        self._odometry: dict[str, tuple[float, float] | None] = {}
        self._log = LogLimit(self._clock)

    def open(self) -> None:
        """Begin to read."""
        self._read(TFMessage, "/tf", partial(self._on_tf, "", is_static=False))
        self._read(TFMessage, "/tf_static", partial(self._on_tf, "", is_static=True))
        for name in self._owners.names:
            self._read_robot(name, f"/{name}")
        if self._owners.sole:
            self._read_robot(self._owners.sole, "")

    def _read_robot(self, robot: str, namespace: str) -> None:
        """Read the topics of *robot* in *namespace*; an empty one is for a sole robot."""
        frames_of = robot if namespace else ""
        if namespace:
            self._read(TFMessage, f"{namespace}/tf", partial(self._on_tf, robot, is_static=False))
            self._read(TFMessage, f"{namespace}/tf_static", partial(self._on_tf, robot, is_static=True))
        self._read(
            PoseWithCovarianceStamped, f"{namespace}/amcl_pose", partial(self._on_amcl, robot, frames_of, namespace)
        )
        self._read(PoseWithCovarianceStamped, f"{namespace}/initialpose", partial(self._on_initial_pose, robot))
        if namespace or robot != DEFAULT_ROBOT:
            own = namespace or f"/{DEFAULT_ROBOT}"
            self._read(PoseStamped, f"{own}/pose", partial(self._on_pose, robot, frames_of, f"{own}/pose"))
            self._read(RobotRoom, f"{own}/room", partial(self._on_room, robot, f"{own}/room"))

    def _read(self, message_type: type[MessageT], topic: str, handle: Callable[[MessageT], None]) -> None:
        """Call *handle* with each message on *topic*, first with those that publishers keep for late subscribers."""
        try:
            self._node.create_subscription(message_type, topic, handle, _DEPTH)
            if not self._is_kept(topic):
                return
            qos = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            kept = self._node.create_subscription(message_type, topic, None, qos)
        except TypeMismatchError as exc:
            self._node.log.warning(REFUSED, message=f"{topic} is not read: {exc}", topic=topic)
            return
        while (message := kept.take()) is not None:
            handle(message)
        kept.close()

    def _is_kept(self, topic: str) -> bool:
        """Return whether a publisher keeps its messages; to ask another one for them is logged as a mistake."""
        publishers = self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER, name=topic)
        return any(one.qos is not None and one.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL for one in publishers)

    def _on_tf(self, robot: str, message: TFMessage, *, is_static: bool) -> None:
        topic = f"/{robot}/tf" if robot else "/tf"
        if foreign := self._owners.foreign(topic, message, (robot,) if robot else self._owners.names):
            self._refuse(topic, f"{foreign} may not be stated there")
            return
        now, stamp = self._clock.monotonic(), self._clock.now()
        for transform in message.transforms:
            try:
                self._tracker.add_life(self._frames.add(transform, robot, now, stamp, is_static=is_static))
            except TransformException as exc:
                self._refuse(topic, str(exc))

    def _on_amcl(self, robot: str, frames_of: str, namespace: str, message: PoseWithCovarianceStamped) -> None:
        topic, odometry = f"{namespace}/amcl_pose", f"{namespace}/odom"
        if odometry not in self._odometry:  # it comes often, and is of no use without these poses
            self._read(Odometry, odometry, partial(self._on_odometry, robot, namespace))
        self._odometry[odometry] = None
        x, y = (max(0.0, message.pose.covariance[index]) for index in (0, 7))
        sigma = math.sqrt(max(x, y))
        evidence = PoseEvidence(topic, 0.0, AMCL_LIMIT, max(_LEAST_ERROR, math.sqrt(x + y)), by_life=True, sigma=sigma)
        self._add_pose(robot, evidence, message.pose.pose, message.header, frames_of)

    def _on_initial_pose(self, robot: str, _message: PoseWithCovarianceStamped) -> None:
        self._tracker.make_unsure(robot, "it was told a new initial pose")

    def _on_odometry(self, robot: str, namespace: str, message: Odometry) -> None:
        self._tracker.add_life(robot)
        point, begin = message.pose.pose.position, self._odometry[f"{namespace}/odom"]
        if begin is None:
            self._odometry[f"{namespace}/odom"] = point.x, point.y
        elif not math.dist(begin, (point.x, point.y)) <= ODOMETRY_MOVED:  # also if one is NaN
            self._tracker.drop(robot, f"{namespace}/amcl_pose")

    def _on_pose(self, robot: str, frames_of: str, topic: str, message: PoseStamped) -> None:
        evidence = PoseEvidence(topic, 0.0, self._tracker.settings[robot].limit, _POSE_ERROR)
        self._add_pose(robot, evidence, message.pose, message.header, frames_of)

    def _on_room(self, robot: str, topic: str, message: RobotRoom) -> None:
        if message.robot != robot:
            self._refuse(topic, f"the robot {message.robot[:100]!r} may not be stated there")
            return
        self._tracker.add_room(robot, topic, message.room[:_LONGEST_ROOM], TAG_LIMIT)

    def _add_pose(self, robot: str, evidence: PoseEvidence, pose: Pose, header: Header, frames_of: str) -> None:
        frame = self._frames.name_of(header.frame_id, frames_of)
        position = self._frames.in_map(pose, frame)
        ahead = header.stamp.to_seconds() - self._clock.now()
        if ahead > MOST_AHEAD:
            self._refuse(evidence.source, f"it is {ahead:.0f} s ahead of our clock")
        elif position is None:
            self._refuse(evidence.source, f"no static transform joins its frame {frame[:100]!r} to map")
        else:
            now, floor = self._clock.monotonic(), self._tracker.floor_of(robot)
            self._tracker.add(robot, evidence._replace(received_at=now, position=position, floor=floor))

    def _refuse(self, topic: str, problem: str) -> None:
        if self._log.allows(topic) is not None:
            self._node.log.warning(REFUSED, message=f"a message on {topic} was refused: {problem}", topic=topic)
