"""ROS ``std_srvs``: services without types of their own."""

from homebot.messages.message import Message, ServiceType

__all__ = [
    "Empty",
    "EmptyRequest",
    "EmptyResponse",
    "SetBool",
    "SetBoolRequest",
    "SetBoolResponse",
    "SuccessResponse",
    "Trigger",
    "TriggerRequest",
]


class EmptyRequest(Message, ros_type="std_srvs/srv/Empty_Request"):
    """No fields: the call is the request."""


class EmptyResponse(Message, ros_type="std_srvs/srv/Empty_Response"):
    """No fields: the answer says that it was done."""


class TriggerRequest(Message, ros_type="std_srvs/srv/Trigger_Request"):
    """No fields: the call is the request."""


class SetBoolRequest(Message, ros_type="std_srvs/srv/SetBool_Request"):
    """Switch something on (true) or off (false)."""

    data: bool


class SuccessResponse(Message, ros_type="std_srvs/srv/Trigger_Response"):
    """The result of a :class:`TriggerRequest`."""

    success: bool
    message: str


class SetBoolResponse(SuccessResponse, ros_type="std_srvs/srv/SetBool_Response"):
    """The result of a :class:`SetBoolRequest`."""


Empty = ServiceType("std_srvs/srv/Empty", EmptyRequest, EmptyResponse)
Trigger = ServiceType("std_srvs/srv/Trigger", TriggerRequest, SuccessResponse)
SetBool = ServiceType("std_srvs/srv/SetBool", SetBoolRequest, SetBoolResponse)
