"""Actions of the control layer."""

from typing import Annotated, Literal

from pydantic import Field

from homebot.devices.command_messages import CommandDevicesRequest, CommandDevicesResponse, CommandedPart, Setting
from homebot.messages.action import ActionType
from homebot.messages.message import Message, ServiceAnswer, UInt32


class CommandDevicesGoal(CommandDevicesRequest, ros_type="homebot/action/CommandDevices_Goal"):
    """A command in words, with the fields of the service ``/devices/command``."""


class CommandDevicesResult(CommandDevicesResponse, ros_type="homebot/action/CommandDevices_Result"):
    """The outcomes, as for that service; for a cancelled goal, those known by then."""


class CommandDevicesFeedback(Message, ros_type="homebot/action/CommandDevices_Feedback"):
    """One outcome, as soon as it is known.

    Attributes:
        waiting: The number of parts still without one.
    """

    commanded: CommandedPart
    waiting: UInt32


CommandDevicesAction = ActionType(
    "homebot/action/CommandDevices", CommandDevicesGoal, CommandDevicesResult, CommandDevicesFeedback
)


class HoldDeviceGoal(Message, ros_type="homebot/action/HoldDevice_Goal"):
    """A value of a part to hold until the goal is cancelled.

    Attributes:
        device: The id or the name of the device.
        part: The id of the part; empty for the only one that takes the held setting, not counting configuration parts.
        by: The holder, as a word for people, such as ``robot``; empty for the name of the client or node.
        seconds: How long it is held after the first success; 0 for until it is cancelled.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, set by the door.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
    """

    device: str
    part: str = ""
    setting: Setting
    by: Annotated[str, Field(max_length=100)] = ""
    seconds: Annotated[float, Field(ge=0.0)] = 0.0
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()


class HoldDeviceResult(ServiceAnswer, ros_type="homebot/action/HoldDevice_Result"):
    """The end of a hold; a success if its time is over, or it was cancelled while the value was held."""


class HoldDeviceFeedback(Message, ros_type="homebot/action/HoldDevice_Feedback"):
    """The state of a hold, once a second.

    Attributes:
        phase: ``commanding`` until the device obeys; ``held``; ``outranked`` for a while by a person's hand.
        seconds_left: Seconds until the hold ends; 0 without a limit.
        message: The newest outcome, as text; empty while the first one is awaited.
    """

    phase: Literal["commanding", "held", "outranked"]
    seconds_left: float
    message: str = ""


HoldDevice = ActionType("homebot/action/HoldDevice", HoldDeviceGoal, HoldDeviceResult, HoldDeviceFeedback)
