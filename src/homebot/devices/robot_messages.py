"""Messages about robots: where they are, and in which room."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

__all__ = ["RobotPose", "RobotRoom", "WhereIsRobot", "WhereIsRobotRequest", "WhereIsRobotResponse"]


class RobotPose(Message):
    """The position of a robot, as on ``/robots/poses``.

    Attributes:
        room: The room that it is in; empty where that is not known.
        is_nearest_room: Whether it is in no room, and this is the nearest one.
        floor: The floor that it is on; empty where that is not stated.
        has_position: Whether ``x``, ``y`` and ``yaw`` are known, and not the room alone.
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
        yaw: Radians from the x axis, counter-clockwise.
        error: Metres by which the position may be wrong.
        source: The topic, device or tag that it is from.
        limit: Seconds after that, or after the robot's last sign of life, for which it counts.
        counts: Whether it counts now; one that does not is published once more, with False.
        is_sure: Whether the robot knows where it is; False after it was carried away.
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


class RobotRoom(Message):
    """A robot's own statement of the room that it is in, as on ``/NAME/room``."""

    key_field = "robot"

    robot: str
    room: str


class WhereIsRobotRequest(Message):
    """A question for the place of a robot.

    Attributes:
        robot: Its name; empty, or ``robot``, where there is one robot.
    """

    robot: str = ""


class WhereIsRobotResponse(ServiceAnswer):
    """The place of a robot, or the reason why it is not known.

    Attributes:
        pose: The last pose; none if there was none.
        age: Seconds since it was received.
        is_mistake: Whether there is no such robot.
    """

    pose: tuple[RobotPose, ...] = ()
    age: float = 0.0
    is_mistake: bool = False


WhereIsRobot = ServiceType("homebot/srv/WhereIsRobot", WhereIsRobotRequest, WhereIsRobotResponse)
