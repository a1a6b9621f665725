"""What a message lacks: zero, false or empty, at any depth."""

from enum import StrEnum
from typing import Annotated, Any

import pytest
from pydantic import Field

from homebot.bridges.rosbridge.types import partial_message_from_client
from homebot.errors import TypeMismatchError
from homebot.messages import message as fields
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import PoseStamped
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.messages.std_msgs import Header


class Mode(StrEnum):
    ECO = "eco"


class Vector(Message, ros_type="test_msgs/msg/Vector"):
    """Two numbers."""

    x: float
    y: fields.Float32


class Twist(Message, ros_type="test_msgs/msg/Twist"):
    """A message of each kind of field."""

    linear: Vector
    path: tuple[Vector, ...]
    covariance: Annotated[tuple[float, ...], Field(min_length=3, max_length=3)]
    raw: bytes
    is_fast: bool
    frame: str
    steps: fields.UInt8 = 7


class Choice(Message, ros_type="test_msgs/msg/Choice"):
    """A text of an enumeration."""

    mode: Mode


NOW = 12.5


def test_nothing_at_all_is_a_message_of_zeros() -> None:
    message, missing = partial_message_from_client(Twist, {}, NOW)
    assert missing == ("linear", "path", "covariance", "raw", "is_fast", "frame")
    assert message == Twist(
        linear=Vector(x=0.0, y=0.0), path=(), covariance=(0.0, 0.0, 0.0), raw=b"", is_fast=False, frame=""
    )


def test_messages_inside_are_completed_too() -> None:
    whole = {"covariance": [1.0] * 3, "raw": "", "is_fast": True, "frame": "map"}
    message, missing = partial_message_from_client(
        Twist, whole | {"linear": {"x": 2}, "path": [{"y": 1}, {"x": 3}]}, NOW
    )
    assert missing == ("linear.y", "path.x", "path.y")
    assert message.model_dump()["linear"] == {"x": 2.0, "y": 0.0}
    assert message.model_dump()["path"] == ({"x": 0.0, "y": 1.0}, {"x": 3.0, "y": 0.0})


@pytest.mark.parametrize(
    ("message_type", "values", "problem"),
    [
        (Twist, {"lineal": {"x": 1}}, "field 'lineal' is unknown"),
        (Twist, {"linear": {"x": "1"}}, "field 'linear.x': input should be a valid number"),
        (Choice, {}, "field 'mode' is missing"),
    ],
)
def test_a_wrong_field_is_refused(message_type: type[Message], values: dict[str, object], problem: str) -> None:
    with pytest.raises(TypeMismatchError, match=problem):
        partial_message_from_client(message_type, values, NOW)


@pytest.mark.parametrize("header", [{}, {"header": {}}, {"header": {"stamp": "now", "frame_id": ""}}])
def test_a_header_that_lacks_its_stamp_or_is_not_there_is_of_now(header: dict[str, object]) -> None:
    """ROSBRIDGE_PROTOCOL.md, section 3.2.3; a header of a message inside is as empty as the rest."""
    stated, missing = partial_message_from_client(PoseStamped, header, NOW)
    now = Header(stamp=Time(sec=12, nanosec=500_000_000), frame_id="")
    assert stated == zero_message(PoseStamped).model_copy(update={"header": now})
    assert set(missing) <= {"pose", "header.frame_id"}
    goal: Any = find_action("nav2_msgs/action/NavigateToPose").Goal
    assert partial_message_from_client(goal, {}, NOW)[0] == zero_message(goal)
