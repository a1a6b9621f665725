"""Parameters as rclpy's programs know them."""

from __future__ import annotations

from enum import IntEnum

from homebot.compat.interfaces import InterfaceMessage, from_message
from homebot.graph import Parameter as GraphParameter
from homebot.graph.parameters import Value
from homebot.messages.rcl_interfaces import Parameter as ParameterMessage
from homebot.messages.rcl_interfaces import ParameterValue

__all__ = ["Parameter"]


class Parameter:
    """A parameter's name, type and value.

    Raises:
        ParameterError: No parameter can have the value.
    """

    class Type(IntEnum):
        """The kind of the value."""

        NOT_SET = 0
        BOOL = 1
        INTEGER = 2
        DOUBLE = 3
        STRING = 4
        BYTE_ARRAY = 5
        BOOL_ARRAY = 6
        INTEGER_ARRAY = 7
        DOUBLE_ARRAY = 8
        STRING_ARRAY = 9

    def __init__(self, name: str, type_: Type | None = None, value: Value | None = None) -> None:
        self.name = name
        self.value = value
        message = None if value is None else GraphParameter(name, value).to_message().value
        self._message = ParameterValue(type=0) if message is None else message
        self.type_ = Parameter.Type(self._message.type) if type_ is None else type_

    def get_parameter_value(self) -> InterfaceMessage:
        """Return the value as ``rcl_interfaces/msg/ParameterValue``."""
        return from_message(self._message)

    def to_parameter_msg(self) -> InterfaceMessage:
        """Return it as ``rcl_interfaces/msg/Parameter``."""
        return from_message(ParameterMessage(name=self.name, value=self._message))
