"""Actions of the control layer."""

from typing import Annotated, Literal

from pydantic import Field

from homebot.devices.command_messages import CommandDevicesRequest, CommandDevicesResponse, CommandedPart, Setting
from homebot.messages.action import ActionType
from homebot.messages.message import Message, ServiceAnswer, UInt32

__all__ = [
    "CommandDevicesAction",
    "CommandDevicesFeedback",
    "CommandDevicesGoal",
    "CommandDevicesResult",
    "HoldDevice",
    "HoldDeviceFeedback",
    "HoldDeviceGoal",
    "HoldDeviceResult",
]


class CommandDevicesGoal(CommandDevicesRequest, ros_type="homebot/action/CommandDevices_Goal"):
    """A command in words, with the fields of the service ``/devices/command``."""


class CommandDevicesResult(CommandDevicesResponse, ros_type="homebot/action/CommandDevices_Result"):
    """The outcomes, as of that service; of a cancelled goal those that were known."""


class CommandDevicesFeedback(Message, ros_type="homebot/action/CommandDevices_Feedback"):
    """One outcome, when it is known.

    Attributes:
        waiting: The number of parts without one.
    """

    commanded: CommandedPart
    waiting: UInt32


CommandDevicesAction = ActionType(
    "homebot/action/CommandDevices", CommandDevicesGoal, CommandDevicesResult, CommandDevicesFeedback
)


class HoldDeviceGoal(Message, ros_type="homebot/action/HoldDevice_Goal"):
    """A value of a part, to be kept until the goal is cancelled.

    Attributes:
        device: The id or the name of the device.
        part: The id of the part; empty for the only one that takes the held setting, parts for configuration aside.
        by: The holder, in a word for people, such as ``robot``; empty for the name of the client or node.
        seconds: The time for which it is held, from the first success; 0 until it is cancelled.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, where the door sets it.
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
        phase: ``commanding`` until the device obeys, ``held``, or ``outranked`` by a person's hand for a while.
        seconds_left: Of the hold; 0 without a limit.
        message: The newest outcome, as text; empty while the first one is awaited.
    """

    phase: Literal["commanding", "held", "outranked"]
    seconds_left: float
    message: str = ""


HoldDevice = ActionType("homebot/action/HoldDevice", HoldDeviceGoal, HoldDeviceResult, HoldDeviceFeedback)
