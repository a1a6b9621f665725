"""Messages about robots: their positions and rooms."""

from typing import Final

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

WAY_LIMIT_S: Final = 60.0
"""Seconds for which a robot counts as on its way since it was last sent, planned its way, or moved."""


class RobotPose(Message):
    """The position of a robot, on ``/robots/poses``.

    Attributes:
        room: Its room; empty if unknown.
        is_nearest_room: Whether it is in no room, and this is the nearest one.
        floor: Its floor; empty if it is not stated.
        has_position: Whether ``x``, ``y`` and ``yaw`` are known, rather than only the room.
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
        yaw: Radians from the x axis, counter-clockwise.
        error: Metres by which the position may be wrong.
        source: The topic, device or tag that it comes from.
        limit: Seconds after that, or after the robot's last sign of life, for which it is valid.
        counts: Whether it is valid; an expired pose is published once more, with False.
        is_sure: Whether the robot knows where it is; False after it was carried away.
        way: The rooms that need light for it: its room and the one that it drives to; none unless it is on its way.
    """

    key_field = "robot"

    robot: str
    room: str = ""
    is_nearest_room: bool = False
    floor: str = ""
    has_position: bool = False
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    error: float = 0.0
    source: str = ""
    received_at: Time
    limit: float
    counts: bool = True
    is_sure: bool = True
    way: tuple[str, ...] = ()


class RobotRoom(Message):
    """A robot's own statement of its room, on ``/NAME/room``."""

    key_field = "robot"

    robot: str
    room: str


class WhereIsRobotRequest(Message):
    """Request for the position of a robot.

    Attributes:
        robot: Its name; empty, or ``robot``, if there is only one robot.
    """

    robot: str = ""


class WhereIsRobotResponse(ServiceAnswer):
    """The position of a robot, or the reason why it is unknown.

    Attributes:
        pose: The last pose; none if there was none.
        age: Seconds since it was received.
        is_mistake: Whether there is no such robot.
        robot: Its full name; empty if there is no such robot.
        is_gone: Whether its connection ended: its device is unreachable, or all publishers of its own topics have left,
            and it has shown no sign of life for the ``limit`` of its table.
        is_sole: Whether names of topics and actions without a namespace are its.
    """

    pose: tuple[RobotPose, ...] = ()
    age: float = 0.0
    is_mistake: bool = False
    robot: str = ""
    is_sole: bool = False
    is_gone: bool = False


WhereIsRobot = ServiceType("homebot/srv/WhereIsRobot", WhereIsRobotRequest, WhereIsRobotResponse)
