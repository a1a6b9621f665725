"""ROS ``rcl_interfaces``: log lines and parameters."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import ByteArray, Float64Array, Int64Array, Message, UInt8, UInt32


class Log(Message, ros_type="rcl_interfaces/msg/Log"):
    """One log line, on ``/rosout``.

    Attributes:
        level: DEBUG 10, INFO 20, WARN 30, ERROR 40, FATAL 50.
        name: The logger: the node's full name with dots, without a leading dot.
    """

    stamp: Time
    level: UInt8
    name: str
    msg: str
    file: str
    function: str
    line: UInt32


class ParameterValue(Message, ros_type="rcl_interfaces/msg/ParameterValue"):
    """A value with its type.

    Attributes:
        type: 0 not set, 1 bool, 2 integer, 3 double, 4 string, 5 byte[], 6 bool[], 7 integer[], 8 double[],
            9 string[]; selects the field that contains the value.
    """

    type: UInt8
    bool_value: bool = False
    integer_value: int = 0
    double_value: float = 0.0
    string_value: str = ""
    byte_array_value: ByteArray = ()
    bool_array_value: tuple[bool, ...] = ()
    integer_array_value: Int64Array = ()
    double_array_value: Float64Array = ()
    string_array_value: tuple[str, ...] = ()


class Parameter(Message, ros_type="rcl_interfaces/msg/Parameter"):
    """A parameter's name and value."""

    name: str
    value: ParameterValue


class ParameterEvent(Message, ros_type="rcl_interfaces/msg/ParameterEvent"):
    """The changes among the parameters of one node."""

    stamp: Time
    node: str
    new_parameters: tuple[Parameter, ...]
    changed_parameters: tuple[Parameter, ...]
    deleted_parameters: tuple[Parameter, ...]
