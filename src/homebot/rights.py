"""The rights of clients, and the one that each service of homebot needs. Pure."""

from enum import Enum
from typing import NamedTuple


class Right(Enum):
    """One right of a client, by the first word of a right in a ``scope``."""

    READ = "read"
    """Subscribe to topics, and call services that change nothing."""

    ACT = "act"
    """Command devices, and communicate with apps and other clients."""

    ASK = "ask"
    """Command devices once a person agrees, to each command; as :attr:`ACT` otherwise."""

    MANAGE = "manage"
    """Change homebot itself: its parameters, its index."""

    RAW = "raw"
    """Publish as homebot's own parts, and to gateways, bypassing every check."""

    ROBOT = "robot"
    """Act as a robot: publish its pose and everything below its name, and request doors."""


class OfferedService(NamedTuple):
    """A service or an action of homebot itself.

    Attributes:
        name: Its full name, such as ``/devices/command``.
        right: The right that a client needs; there is no default.
        ros_type: Its type, such as ``homebot/srv/AchieveWords``, if it is shown on the graph before it is loaded.
        waits: Whether it answers only once devices have, however slow, or a person has agreed.
    """

    name: str
    right: Right
    ros_type: str = ""
    waits: bool = False
