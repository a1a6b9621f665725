"""Frozen, typed messages with exact ROS field types; each is imported on first use.

ROS messages are in modules named after their packages: ``from homebot.messages.geometry_msgs import Twist``.
"""

from typing import TYPE_CHECKING

from homebot.support.lazy_names import lazy_names

if TYPE_CHECKING:
    from homebot.messages.builtin_interfaces import Duration as Duration
    from homebot.messages.builtin_interfaces import Time as Time
    from homebot.messages.interfaces import Interfaces as Interfaces
    from homebot.messages.message import Message as Message
    from homebot.messages.message import ServiceType as ServiceType
    from homebot.messages.rcl_interfaces import Log as Log
    from homebot.messages.rcl_interfaces import Parameter as Parameter
    from homebot.messages.rcl_interfaces import ParameterEvent as ParameterEvent
    from homebot.messages.rcl_interfaces import ParameterValue as ParameterValue
    from homebot.messages.std_msgs import Bool as Bool
    from homebot.messages.std_msgs import Empty as Empty
    from homebot.messages.std_msgs import Float32 as Float32
    from homebot.messages.std_msgs import Float64 as Float64
    from homebot.messages.std_msgs import Int32 as Int32
    from homebot.messages.std_msgs import Int64 as Int64
    from homebot.messages.std_msgs import String as String
    from homebot.messages.std_msgs import UInt8 as UInt8
    from homebot.messages.std_srvs import SetBool as SetBool
    from homebot.messages.std_srvs import Trigger as Trigger

_NAMES = {
    "homebot.messages.builtin_interfaces": "Duration Time",
    "homebot.messages.interfaces": "Interfaces",
    "homebot.messages.message": "Message ServiceType",
    "homebot.messages.rcl_interfaces": "Log Parameter ParameterEvent ParameterValue",
    "homebot.messages.std_msgs": "Bool Empty Float32 Float64 Int32 Int64 String UInt8",
    "homebot.messages.std_srvs": "SetBool Trigger",
}

__all__ = [name for names in _NAMES.values() for name in names.split()]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(__name__, _NAMES)
