"""Ownership of topics and coordinate frames by the robots of a house. Pure.

A robot with the name ``rosie`` owns all topics below ``/rosie``, and all frames below ``rosie/``. The sole robot of a
house also owns the topics without a namespace on which robots state their poses, and all frames without a slash.
The frame ``map`` belongs to the house: no robot may state its position.
"""

from collections.abc import Iterable, Mapping
from typing import Final, final

from homebot.devices.own_services import own_namespaces
from homebot.errors import InvalidNameError
from homebot.messages.message import Message
from homebot.names import validate_node_name

DEFAULT_ROBOT: Final = "robot"
"""The name of the robot in a house without named robots."""

MAP: Final = "map"
"""The frame of the house, in which positions are stated."""

SHARED_TOPICS: Final = frozenset({"/tf", "/tf_static"})
"""Topics of all robots: each may state its own frames there."""

_SOLE_TOPICS: Final = frozenset({"/amcl_pose", "/initialpose", "/odom", "/plan"})
_SOLE_NAMESPACE: Final = "/robot/"


def check_robot_name(name: str) -> None:
    """Refuse a name under which a robot could not have topics and frames of its own.

    Raises:
        InvalidNameError: It is no name of a node, or homebot's or the house's.
    """
    validate_node_name(name)
    taken = ""
    if name in own_namespaces():
        taken = f"homebot's own topics, /{name}/…"
    elif name == MAP or f"/{name}" in SHARED_TOPICS | _SOLE_TOPICS:
        taken = f"the topic /{name} of all robots"
    elif name == "all":
        taken = "all robots in the rights of clients"
    if taken:
        raise InvalidNameError("robot", name, f"has the name of {taken}; choose another")


@final
class RobotOwners:
    """The robots of a house, with their topics and frames.

    Args:
        frames: The frames on ``/tf`` of each robot of the house that do not begin with its name, by robot.
        guests: Robots that may come, as a token names them.

    Attributes:
        names: The names of all robots, sorted.
        guests: Those of robots that only a token names.
        sole: The only robot of the house, or else the only one that may come; empty if there are several.
    """

    def __init__(self, frames: Mapping[str, Iterable[str]] | None = None, guests: Iterable[str] = ()) -> None:
        own = frames or {}
        self.guests = frozenset(guests) - own.keys()
        self.names = tuple(sorted({*own, *self.guests})) or (DEFAULT_ROBOT,)
        first, *others = sorted(own) or self.names
        self.sole = "" if others else first
        self._by_frame = {frame: robot for robot, names in (frames or {}).items() for frame in names}

    def of_topic(self, topic: str) -> str | None:
        """Return the robot that owns the full name *topic*; empty if each robot may use it, None if no robot owns it.

        If there are several robots, topics that a sole robot would own have the owner ``?``.
        """
        if topic in SHARED_TOPICS:
            return ""
        if topic in _SOLE_TOPICS:
            return self.sole or "?"
        first = topic.split("/", 2)[1]
        if first in self.names:
            return first
        return (self.sole or "?") if topic.startswith(_SOLE_NAMESPACE) else None

    def of_frame(self, frame: str) -> str:
        """Return the robot that owns *frame*; empty if no robot owns it."""
        frame = frame.removeprefix("/")
        first, slash, _ = frame.partition("/")
        if slash and first in self.names:
            return first
        if frame in self._by_frame:
            return self._by_frame[frame]
        return "" if slash or frame == MAP else self.sole

    def foreign(self, topic: str, message: Message, robots: Iterable[str]) -> str:
        """Return the robot or frame in *message* on *topic* that belongs to none of *robots*; empty without one."""
        owner = self.of_topic(topic)
        if owner is None:
            return ""
        own = frozenset(robots)
        for transform in getattr(message, "transforms", ()):
            child = transform.child_frame_id.removeprefix("/")
            if child == MAP or (self.of_frame(child) not in own and not (owner and self._is_plain(child))):
                return f"the frame {child[:100]!r}"
        stated = getattr(message, "robot", owner) if owner else ""
        return f"the robot {stated[:100]!r}" if stated and stated not in own else ""

    def _is_plain(self, frame: str) -> bool:
        """Return whether *frame* does not name a robot; in a robot's namespace it belongs to that robot."""
        return frame.partition("/")[0] not in self.names
