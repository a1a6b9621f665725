"""Frozen, typed messages with exact ROS field types; each is imported when it is first asked for.

Those of ROS are in modules with the names of their packages: ``from homebot.messages.geometry_msgs import Twist``.
"""

from typing import TYPE_CHECKING

from homebot.support.lazy_names import lazy_names

if TYPE_CHECKING:
    from homebot.messages.builtin_interfaces import Duration, Time
    from homebot.messages.interfaces import Interfaces
    from homebot.messages.message import Message, ServiceType
    from homebot.messages.rcl_interfaces import Log, Parameter, ParameterEvent, ParameterValue
    from homebot.messages.std_msgs import Bool, Empty, Float32, Float64, Int32, Int64, String, UInt8
    from homebot.messages.std_srvs import SetBool, Trigger

__all__ = [
    "Bool",
    "Duration",
    "Empty",
    "Float32",
    "Float64",
    "Int32",
    "Int64",
    "Interfaces",
    "Log",
    "Message",
    "Parameter",
    "ParameterEvent",
    "ParameterValue",
    "ServiceType",
    "SetBool",
    "String",
    "Time",
    "Trigger",
    "UInt8",
]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.messages.builtin_interfaces": "Duration Time",
            "homebot.messages.interfaces": "Interfaces",
            "homebot.messages.message": "Message ServiceType",
            "homebot.messages.rcl_interfaces": "Log Parameter ParameterEvent ParameterValue",
            "homebot.messages.std_msgs": "Bool Empty Float32 Float64 Int32 Int64 String UInt8",
            "homebot.messages.std_srvs": "SetBool Trigger",
        },
    )
