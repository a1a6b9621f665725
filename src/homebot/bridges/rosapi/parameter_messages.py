"""Messages of ``rosapi_msgs`` about parameters, field for field.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.messages.message import Message
from homebot.messages.service_type import ServiceType

__all__ = [
    "DeleteParam",
    "DeleteParamRequest",
    "DeleteParamResponse",
    "GetParam",
    "GetParamNames",
    "GetParamNamesRequest",
    "GetParamNamesResponse",
    "GetParamRequest",
    "GetParamResponse",
    "HasParam",
    "HasParamRequest",
    "HasParamResponse",
    "SetParam",
    "SetParamRequest",
    "SetParamResponse",
]


class GetParamRequest(Message):
    """A question for the value of the parameter ``/node:name``."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParam_Request"

    name: str
    default_value: str = ""


class GetParamResponse(Message):
    """Its value as JSON text; ``null`` and the reason where there is none."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParam_Response"

    value: str
    successful: bool
    reason: str


class SetParamRequest(Message):
    """Give the parameter ``/node:name`` a value, written as JSON text."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/SetParam_Request"

    name: str
    value: str


class SetParamResponse(Message):
    """The result of setting a parameter, with the reason of a refusal."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/SetParam_Response"

    successful: bool
    reason: str


class DeleteParamRequest(Message):
    """Delete the parameter ``/node:name``."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/DeleteParam_Request"

    name: str


class DeleteParamResponse(Message):
    """The result of deleting a parameter, with the reason of a refusal."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/DeleteParam_Response"

    successful: bool
    reason: str


class HasParamRequest(Message):
    """Is there a parameter ``/node:name``?"""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/HasParam_Request"

    name: str


class HasParamResponse(Message):
    """The answer to :class:`HasParamRequest`."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/HasParam_Response"

    exists: bool


class GetParamNamesRequest(Message):
    """A question for the names of all parameters."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParamNames_Request"


class GetParamNamesResponse(Message):
    """Their names, as ``/node:name``."""

    ros_type: ClassVar[str] = "rosapi_msgs/srv/GetParamNames_Response"

    names: tuple[str, ...]


GetParam = ServiceType("rosapi_msgs/srv/GetParam", GetParamRequest, GetParamResponse)
SetParam = ServiceType("rosapi_msgs/srv/SetParam", SetParamRequest, SetParamResponse)
DeleteParam = ServiceType("rosapi_msgs/srv/DeleteParam", DeleteParamRequest, DeleteParamResponse)
HasParam = ServiceType("rosapi_msgs/srv/HasParam", HasParamRequest, HasParamResponse)
GetParamNames = ServiceType("rosapi_msgs/srv/GetParamNames", GetParamNamesRequest, GetParamNamesResponse)
