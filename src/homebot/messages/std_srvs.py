"""ROS ``std_srvs``: generic services; ``Empty`` is built from its definition."""

from homebot.messages.message import Message, ServiceType


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


Trigger = ServiceType("std_srvs/srv/Trigger", TriggerRequest, SuccessResponse)
SetBool = ServiceType("std_srvs/srv/SetBool", SetBoolRequest, SetBoolResponse)
