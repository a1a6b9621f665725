"""A command to a part of a device, in the words of the vocabulary."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from homebot.devices.value import Value
from homebot.messages.message import Message, ServiceType

__all__ = ["Command", "SendCommand", "SendCommandResponse"]


class Command(Message):
    """Make a capability have a value. Always absolute: to say it twice changes nothing.

    Attributes:
        key: What the gateway calls the device.
        part: Which part of it.
        capability: Which capability.
        value: What it shall be, in the vocabulary's unit.
        transition: Seconds that the change shall take, where the device can do that.
        code: What an alarm or a lock wants to be told first; a secret, which no text about the command shows.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    key: str
    part: str
    capability: str
    value: Value
    transition: float = 0.0
    code: Annotated[str, Field(repr=False, max_length=255)] = ""


class SendCommandResponse(Message):
    """The gateway's result for a command; it does not prove that the device obeyed.

    Attributes:
        success: Whether the network took it.
        message: Why not.
        problem: Whose no that is: ``refused`` by the part, the gateway or the network, where the same again fails
            again, or the device or its network is ``unreachable`` now.
        unable: Whether it was refused because the part cannot do that as it is described there. Nothing was sent then,
            and another way to the part may do.
    """

    success: bool
    message: str = ""
    problem: Literal["", "refused", "unreachable"] = ""
    unable: bool = False


SendCommand = ServiceType("homebot/srv/SendCommand", Command, SendCommandResponse)
