"""What a message type looks like to ROS."""

from enum import StrEnum
from typing import Annotated, Literal

import pytest
from pydantic import Field

from homebot.errors import UsageError
from homebot.messages import Empty, Log, Message, ParameterEvent, String, Time
from homebot.messages import message as fields
from homebot.messages.action_msgs import GoalInfo
from homebot.messages.definition import definition_text, fields_of, nested_types, zero_message
from homebot.messages.geometry_msgs import PoseWithCovarianceStamped
from homebot.messages.interfaces import find_message
from homebot.messages.numeric_array import NumericArray

SEPARATOR = "=" * 80


class Mood(StrEnum):
    CALM = "calm"
    WILD = "wild"


class Everything(Message):
    flag: bool
    tiny: fields.Int8
    word: fields.UInt16
    ratio: fields.Float32
    name: str
    mood: Mood
    mode: Literal["auto", "manual"]
    raw: bytes
    uuid: Annotated[bytes, Field(min_length=16, max_length=16)]
    short: Annotated[bytes, Field(max_length=8)]
    names: tuple[str, ...]
    position: Annotated[tuple[float, ...], Field(min_length=3, max_length=3)]
    codes: Annotated[tuple[fields.UInt16, ...], Field(max_length=4)]
    some: Annotated[tuple[int, ...], Field(min_length=1)]
    moods: tuple[Mood, ...]
    stamp: Time
    stamps: tuple[Time, ...]


def test_each_python_type_is_one_ros_type() -> None:
    lines = [field.declaration for field in fields_of(Everything)]
    assert lines == [
        "bool flag",
        "int8 tiny",
        "uint16 word",
        "float32 ratio",
        "string name",
        "string mood",
        "string mode",
        "uint8[] raw",
        "uint8[16] uuid",
        "uint8[<=8] short",
        "string[] names",
        "float64[3] position",
        "uint16[<=4] codes",
        "int64[] some",
        "string[] moods",
        "builtin_interfaces/Time stamp",
        "builtin_interfaces/Time[] stamps",
    ]


def test_the_text_of_a_flat_type_is_its_fields() -> None:
    assert definition_text(String) == "string data\n"
    assert definition_text(Time) == "int32 sec\nuint32 nanosec\n"
    assert definition_text(Empty) == ""


def test_the_text_of_a_log_line_is_that_of_rcl_interfaces() -> None:
    """As rosbag2 writes rcl_interfaces/msg/Log, without its comments and constants."""
    assert definition_text(Log) == (
        "builtin_interfaces/Time stamp\n"
        "uint8 level\n"
        "string name\n"
        "string msg\n"
        "string file\n"
        "string function\n"
        "uint32 line\n"
        f"{SEPARATOR}\n"
        "MSG: builtin_interfaces/Time\n"
        "int32 sec\n"
        "uint32 nanosec\n"
    )


def test_nested_types_come_once_each_in_order_of_first_use() -> None:
    assert [kind.ros_type for kind in nested_types(ParameterEvent)] == [
        "builtin_interfaces/msg/Time",
        "rcl_interfaces/msg/Parameter",
        "rcl_interfaces/msg/ParameterValue",
    ]


@pytest.mark.parametrize(
    "annotation", [float | None, dict[str, int], complex, list[int], tuple[int, str], Literal[1, 2]]
)
def test_a_type_that_ros_does_not_know_is_refused(annotation: object) -> None:
    odd = type("Odd", (Message,), {"__annotations__": {"value": annotation}, "__module__": __name__})
    with pytest.raises(UsageError, match=r"Odd\.value: .* has no ROS type"):
        fields_of(odd)


def test_uint8_arrays_are_bytes_and_nothing_else() -> None:
    class Slow(Message):
        data: tuple[fields.UInt8, ...]

    with pytest.raises(UsageError, match=r"Slow\.data: a sequence of uint8 is written bytes"):
        fields_of(Slow)


def test_a_message_without_arguments_has_defaults_and_zeros() -> None:
    """As ROS makes it, also nested and of fixed length."""
    covered = zero_message(PoseWithCovarianceStamped)
    assert covered.pose.covariance == (0.0,) * 36
    assert isinstance(covered.pose.covariance, NumericArray)
    assert (covered.header.frame_id, covered.pose.pose.orientation.w) == ("", 1.0)
    assert zero_message(GoalInfo).goal_id.uuid == bytes(16)
    assert zero_message(find_message("sensor_msgs/msg/BatteryState")).model_dump()["present"] is False
