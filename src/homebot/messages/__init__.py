"""Frozen, typed messages with exact ROS field types."""

from homebot.messages.builtin_interfaces import Duration, Time
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
