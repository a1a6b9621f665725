"""ROS ``std_msgs``: one value each, and the header of others; the rest of the package is made of its text."""

from homebot.messages.std_msgs.header import Header
from homebot.messages.std_msgs.values import Bool, Empty, Float32, Float64, Int32, Int64, String, UInt8
from homebot.messages.text_messages import text_messages

__all__ = ["Bool", "Empty", "Float32", "Float64", "Header", "Int32", "Int64", "String", "UInt8"]

__getattr__ = text_messages("std_msgs")
