"""The service of the control layer that sends raw texts to devices."""

from typing import Annotated, Literal

from pydantic import Field

from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.messages.message import Message, ServiceType

__all__ = ["SendText", "SendTextRequest", "SendTextResponse"]

_MOST_SCOPES = 100


class SendTextRequest(Message):
    """A raw text for a device.

    Attributes:
        device: The id of the device.
        payload: The text.
        issuer: The sender: the name of the node, or ``client:NAME`` for a client of the door.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
        trigger: Its cause, as far as the issuer knows.
    """

    device: str
    payload: str
    issuer: str
    scope: Annotated[tuple[str, ...], Field(max_length=_MOST_SCOPES)] = ()
    trigger: Trigger = NO_TRIGGER


class SendTextResponse(Message):
    """The result; a success does not prove that the device obeyed.

    Attributes:
        success: Whether the gateway has queued the text.
        message: The reason if not, as text.
        problem: ``refused`` by a policy, a lease or the gateway, or the gateway is ``unreachable`` now.
        others: The names of the other parts that would have accepted the text and did not get it.
        command_id: The id of the command in the journal.
    """

    success: bool
    message: str = ""
    problem: Literal["", "refused", "unreachable"] = ""
    others: tuple[str, ...] = ()
    command_id: str = ""


SendText = ServiceType("homebot/srv/SendText", SendTextRequest, SendTextResponse)
