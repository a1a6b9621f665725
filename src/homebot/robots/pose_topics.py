"""The topics on which robots publish their poses, listed in ``docs/robots.md``.

Messages stay queued until :meth:`PoseTopics.read`: frames published 50 times a second are read 10 times a second.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import product
from typing import Any, Final, TypeAlias

import anyio

from homebot.devices.robot_messages import RobotRoom
from homebot.devices.robot_owners import DEFAULT_ROBOT, RobotOwners
from homebot.errors import ClosedError, TypeMismatchError
from homebot.graph import DurabilityPolicy, EntityKind, Node, QoSProfile, Subscription
from homebot.log import LogLimit
from homebot.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped
from homebot.messages.message import Message
from homebot.messages.nav_msgs import Odometry, Path
from homebot.messages.std_msgs import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.places.rigid import MapPose
from homebot.places.transforms import TransformException
from homebot.robots.frames import RobotFrames
from homebot.robots.robot import TAG_LIMIT, TrackedRobot

REFUSED = "robots.refused"

PACE: Final = 0.1
"""The shortest time between two reads of a topic, in seconds."""

MAX_AHEAD: Final = 5.0
"""Seconds by which a stamp may be ahead of our clock: AMCL publishes transforms a second ahead."""

TF_LIMIT: Final = 2.0
AMCL_LIMIT: Final = 10.0
"""Seconds for which each kind of evidence is valid."""

_ODOMETRY_MOVED: Final = 0.25
"""Metres of odometry after which a pose of ``/amcl_pose`` is invalid: AMCL has published the next one by then."""

_POSE_ERROR: Final = 0.3
_TF_ERROR: Final = 0.2
"""The error of a position in metres if its source states no covariance."""

_MIN_ERROR: Final = 0.05
_MIN_TF_ERROR: Final = 0.04
_MAX_ERROR: Final = 1000.0
"""The error in metres if it does; frames are newer than the last pose of AMCL."""

_MAX_ROOM: Final = 100
_DEPTH: Final = 100
_KEPT: Final = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_Handle: TypeAlias = Callable[[str, str, Sequence[Any]], None]
"""Handler of the owning robot (empty for a topic of all robots), the topic, and messages, oldest first."""


class PoseTopics:
    """Reads the pose topics of all robots."""

    def __init__(
        self, node: Node, owners: RobotOwners, robots: Mapping[str, TrackedRobot], on_arrival: Callable[[], None]
    ) -> None:
        self._node, self._owners, self._robots, self._on_arrival = node, owners, robots, on_arrival
        self._now = node.graph.steady_now
        self._frames = RobotFrames(owners)
        self._placed: dict[str, tuple[MapPose, float]] = {}
        self._odometry: dict[str, tuple[float, float] | None] = {}
        self._refused: dict[str, tuple[float, str]] = {}  # the last one by robot, and of topics of all robots
        self._log = LogLimit(node.graph.clock)
        self._readers: list[tuple[Subscription[Message], Callable[[Sequence[Any]], None]]] = []
        self._own: dict[str, set[str]] = {}  # by robot, its own topics that were heard
        rows: dict[str, tuple[type[Message], _Handle]] = {
            "tf_static": (TFMessage, self._on_tf),
            "tf": (TFMessage, self._on_tf),
            "initialpose": (PoseWithCovarianceStamped, self._on_initial_pose),
            "amcl_pose": (PoseWithCovarianceStamped, self._on_amcl),
            "pose": (PoseStamped, self._on_pose),
            "room": (RobotRoom, self._on_room),
            "plan": (Path, self._on_plan),
        }
        namespaces = dict.fromkeys(("", *(f"/{name}" for name in (DEFAULT_ROBOT, *owners.names))))
        for namespace, (name, (kind, handle)) in product(namespaces, rows.items()):
            owner = owners.of_topic(topic := f"{namespace}/{name}")
            if owner in {"", *owners.names}:
                self._subscribe(kind, topic, partial(handle, owner or "", topic))

    def read(self) -> None:
        """Read all queued messages."""
        for subscription, handle in tuple(self._readers):
            if messages := [*iter(subscription.take, None)]:
                handle(messages)
                if owner := self._owners.of_topic(subscription.topic_name):
                    self._own.setdefault(owner, set()).add(subscription.topic_name)
        for robot in self._robots.values():
            pose = self._frames.pose_of(robot)
            if pose is not None and pose != self._placed.get(robot.name):
                self._placed[robot.name] = pose
                error = _TF_ERROR if robot.sigma is None else min(_MAX_ERROR, max(_MIN_TF_ERROR, robot.sigma))
                robot.place("/tf", TF_LIMIT, pose[0], age=self._now() - pose[1], error=error)

    def are_silenced(self, robot: str) -> bool:
        """Return whether *robot* published on its own topics, and no publisher of them is left."""
        publishers = partial(self._node.graph.get_endpoints, kind=EntityKind.PUBLISHER)
        return robot in self._own and not any(publishers(name=topic) for topic in self._own[robot])

    def refusal(self, robot: str, since: float = -math.inf) -> str:
        """Return the last refusal of a message of *robot*, or on a topic of all robots; empty for none *since*."""
        at, text = max((self._refused[name] for name in (robot, "") if name in self._refused), default=(since, ""))
        return text if at > since else ""

    def _subscribe(self, kind: type[Message], topic: str, handle: Callable[[Sequence[Any]], None]) -> None:
        """Pass the messages on *topic* to *handle*, beginning with those kept for late subscribers."""
        try:
            subscription = self._node.create_subscription(kind, topic, None, _DEPTH)
            publishers = self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER, name=topic)
            if any(
                publisher.qos is not None and publisher.qos.durability is _KEPT.durability for publisher in publishers
            ):
                early = self._node.create_subscription(kind, topic, None, _KEPT)  # a mistake for others
                for message in iter(early.take, None):
                    subscription.mailbox.put(message)
                early.close()
        except TypeMismatchError as exc:
            self._node.log.warning(REFUSED, message=f"{topic} is not read: {exc}", topic=topic)
            return
        self._readers.append((subscription, handle))
        self._node.create_task(partial(self._watch, subscription))

    async def _watch(self, subscription: Subscription[Message]) -> None:
        with suppress(ClosedError):
            while True:
                await subscription.mailbox.wait()
                self._on_arrival()
                await anyio.sleep(PACE)

    def _on_tf(self, robot: str, topic: str, messages: Sequence[TFMessage]) -> None:
        """Insert the last transform of each frame; ignore a message with a frame of another robot."""
        last, now = {}, self._now()  # one time, or the frames of a chain would have no common time
        for message in messages:
            if foreign := self._owners.foreign(topic, message, (robot,) if robot else self._owners.names):
                self._refuse(topic, f"{foreign} may not be stated there")
            else:
                last.update({transform.child_frame_id: transform for transform in message.transforms})
        for transform in last.values():
            if self._is_ahead(topic, transform.header):
                continue
            try:
                owner = self._frames.add(transform, robot, now, is_static=topic.endswith("/tf_static"))
                self._robots[owner].add_life()
            except TransformException as exc:
                self._refuse(topic, str(exc))

    def _on_amcl(self, robot: str, topic: str, messages: Sequence[PoseWithCovarianceStamped]) -> None:
        odometry = f"{topic.rpartition('/')[0]}/odom"
        if odometry not in self._odometry:  # it is frequent, and useless without these poses
            self._subscribe(Odometry, odometry, partial(self._on_odometry, robot, odometry))
        self._odometry[odometry] = None
        for message in messages:
            xx, yy = (max(0.0, message.pose.covariance[index]) for index in (0, 7))
            error = min(_MAX_ERROR, max(_MIN_ERROR, math.sqrt(xx + yy)))
            if self._place(robot, topic, AMCL_LIMIT, error, message.pose.pose, message.header):
                self._robots[robot].state_sigma(math.sqrt(max(xx, yy)))

    def _on_initial_pose(self, robot: str, _topic: str, _messages: object) -> None:
        self._robots[robot].doubt("it received a new initial pose")

    def _on_odometry(self, robot: str, topic: str, messages: Sequence[Odometry]) -> None:
        self._robots[robot].add_life()
        first, last = (messages[index].pose.pose.position for index in (0, -1))
        begin = self._odometry[topic] = self._odometry[topic] or (first.x, first.y)
        if not math.dist(begin, (last.x, last.y)) <= _ODOMETRY_MOVED:  # true for NaN too
            self._robots[robot].drop(f"{topic.rpartition('/')[0]}/amcl_pose")

    def _on_pose(self, robot: str, topic: str, messages: Sequence[PoseStamped]) -> None:
        for message in messages:
            self._place(robot, topic, self._robots[robot].settings.limit, _POSE_ERROR, message.pose, message.header)

    def _on_room(self, robot: str, topic: str, messages: Sequence[RobotRoom]) -> None:
        for message in messages:
            if message.robot not in {robot, ""}:
                self._refuse(topic, f"the robot {message.robot[:100]!r} may not be stated there")
            elif room := message.room.strip()[:_MAX_ROOM]:
                self._robots[robot].place(topic, TAG_LIMIT, room=room)
            else:
                self._refuse(topic, "it names no room")

    def _on_plan(self, robot: str, topic: str, messages: Sequence[Path]) -> None:
        """Let the robot be on its way to the end of its last path; one without poses ends its way."""
        path = messages[-1]
        frame = self._frames.name_of(path.header.frame_id, robot if topic.startswith(f"/{robot}/") else "")
        if self._is_ahead(topic, path.header):
            return
        try:
            end = self._frames.in_map(path.poses[-1].pose, frame)[:2] if path.poses else None
        except TransformException as exc:
            self._refuse(topic, str(exc))
        else:
            self._robots[robot].head_for(end)

    def _place(self, robot: str, topic: str, limit: float, error: float, pose: Pose, header: Header) -> bool:
        """Place *robot* at a pose; return False if the pose is refused."""
        frame = self._frames.name_of(header.frame_id, robot if topic.startswith(f"/{robot}/") else "")
        if self._is_ahead(topic, header):
            return False
        try:
            position = self._frames.in_map(pose, frame)
        except TransformException as exc:
            self._refuse(topic, str(exc))
            return False
        self._robots[robot].place(topic, limit, position, error=error)
        return True

    def _is_ahead(self, topic: str, header: Header) -> bool:
        """Return whether a message is refused because its stamp is too far ahead."""
        ahead = header.stamp.to_seconds() - self._node.graph.clock.now()
        if ahead > MAX_AHEAD:
            self._refuse(topic, f"it is {ahead:.0f} s ahead of our clock")
        return ahead > MAX_AHEAD

    def _refuse(self, topic: str, problem: str) -> None:
        text = f"a message on {topic} was refused: {problem}"
        self._refused[self._owners.of_topic(topic) or ""] = self._now(), text
        if self._log.allows(topic) is not None:
            self._node.log.warning(REFUSED, message=text, topic=topic)
