"""ROS ``std_srvs``: services without types of their own."""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = ["SetBool", "SetBoolRequest", "SetBoolResponse", "SuccessResponse", "Trigger", "TriggerRequest"]


class TriggerRequest(Message):
    """Nothing to say: the call is the request."""

    ros_type: ClassVar[str] = "std_srvs/srv/Trigger_Request"


class SetBoolRequest(Message):
    """Switch something on (true) or off (false)."""

    ros_type: ClassVar[str] = "std_srvs/srv/SetBool_Request"

    data: bool


class SuccessResponse(Message):
    """The result of a :class:`TriggerRequest`.

    Attributes:
        success: True when it did.
        message: Why not, or more about it.
    """

    ros_type: ClassVar[str] = "std_srvs/srv/Trigger_Response"

    success: bool
    message: str


class SetBoolResponse(SuccessResponse):
    """The result of a :class:`SetBoolRequest`."""

    ros_type: ClassVar[str] = "std_srvs/srv/SetBool_Response"


Trigger = ServiceType("std_srvs/srv/Trigger", TriggerRequest, SuccessResponse)
SetBool = ServiceType("std_srvs/srv/SetBool", SetBoolRequest, SetBoolResponse)
