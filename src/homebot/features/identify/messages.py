"""Action that identifies the device in view: the candidates change in codes of their own, and a sensor looks."""

from typing import Annotated

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.messages.action import ActionType
from homebot.messages.message import Message, ServiceAnswer, UInt32

MAX_CANDIDATES = 32

_Name = Annotated[str, Field(max_length=300)]


class IdentifyDeviceGoal(Message, ros_type="homebot/action/IdentifyDevice_Goal"):
    """The candidates, and the sensor that looks at one of them.

    Attributes:
        candidates: The id or the name of a device, or a query as for ``homebot do``; 1 to 32 parts.
        topic: A topic with a number, such as ``sensor_msgs/Illuminance`` or ``std_msgs/Float64``, or with pictures,
            ``sensor_msgs/Image`` or ``CompressedImage``; or a device that reports its illuminance within 5 s; empty
            for the light sensor in the room of the candidates.
        region: Of pictures, in pixels: x, y, width and height; empty for all.
        sure: The probability that is enough.
        seconds: The time limit.
        least_effect: The least change of the sensor's value by a device in view; 0 for three deviations of a look,
            and at least 5 % of the value.
        at_night: Whether the devices may change from 22:00 to 07:00 and in the quiet hours too.
        robot: The robot of the sensor; with its pose, and *distance*, the position of the device is kept as ``seen``.
        bearing: The direction of the region from the robot, in radians, counter-clockwise from its heading.
        distance: Metres from the robot; 0 if unknown.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, set by the door.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
    """

    candidates: Annotated[str, Field(max_length=1000)]
    topic: _Name = ""
    region: Annotated[tuple[UInt32, ...], Field(max_length=4)] = ()
    sure: Annotated[float, Field(ge=0.5, le=0.9999)] = 0.99
    seconds: Annotated[float, Field(ge=5.0, le=600.0)] = 60.0
    least_effect: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0
    at_night: bool = False
    robot: _Name = ""
    bearing: Annotated[float, Field(allow_inf_nan=False)] = 0.0
    distance: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()


class CandidateState(Message):
    """The state of a candidate.

    Attributes:
        effect: By how much it changes the sensor's value from dark to bright.
        deviation: The standard deviation of *effect*.
        problem: Why it takes part no more, such as that it did not obey; empty if it does.
    """

    device: str
    part: str
    name: str
    probability: float
    effect: float
    deviation: float
    problem: str = ""


class LookRecord(Message):
    """One look, after all candidates had settled.

    Attributes:
        at: Seconds since the first command.
        value: The mean of the sensor's value for a second.
        deviation: The standard deviation of *value*.
        levels: Of each candidate, from 0 (dark) to 1 (bright).
    """

    at: float
    value: float
    deviation: float
    levels: tuple[float, ...]


class IdentifyDeviceFeedback(Message, ros_type="homebot/action/IdentifyDevice_Feedback"):
    """The state after a look.

    Attributes:
        none: The probability of none of the candidates.
    """

    look: LookRecord
    none: float
    candidates: tuple[CandidateState, ...]


class IdentifyDeviceResult(ServiceAnswer, ros_type="homebot/action/IdentifyDevice_Result"):
    """The device in view, or none of the candidates; a success if that is sure.

    Attributes:
        device: The id of the device; empty for none of the candidates, and if it is not sure.
        part: The id of its part.
        name: Its name.
        probability: That of the answer, or of the likeliest one if it is not sure.
        at: Its position from the pose of the robot, which is kept; empty if it is unknown.
        left_out: The devices of the query that did not take part, with the reasons.
    """

    device: str = ""
    part: str = ""
    name: str = ""
    probability: float = 0.0
    none: float = 0.0
    at: str = ""
    candidates: tuple[CandidateState, ...] = ()
    looks: tuple[LookRecord, ...] = ()
    left_out: tuple[KeyValue, ...] = ()


IdentifyDevice = ActionType(
    "homebot/action/IdentifyDevice", IdentifyDeviceGoal, IdentifyDeviceResult, IdentifyDeviceFeedback
)
