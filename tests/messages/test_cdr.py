"""Messages in CDR, as ROS 2 writes them."""

import math
import struct
from typing import Annotated

import pytest
from pydantic import Field

from homebot.messages import Empty, Int32, String, Time
from homebot.messages import message as fields
from homebot.messages.cdr import message_to_cdr
from homebot.messages.message import Message


class Mixed(Message, ros_type="test_msgs/msg/Mixed"):
    """Values of every size, one after the other."""

    flag: bool
    number: float
    small: fields.UInt8
    text: str
    raw: bytes
    count: fields.Int16
    empty: Empty
    times: tuple[Time, ...]
    fixed: Annotated[tuple[float, ...], Field(min_length=2, max_length=2)]
    names: tuple[str, ...]


class Precise(Message, ros_type="test_msgs/msg/Precise"):
    """Numbers that may be too large for their type."""

    values: tuple[fields.Float32, ...]


def hexed(text: str) -> bytes:
    return bytes.fromhex("00 01 00 00" + text)


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (String(data="hello"), "06 00 00 00 68 65 6c 6c 6f 00"),
        (String(data="é"), "03 00 00 00 c3 a9 00"),
        (String(data=""), "01 00 00 00 00"),
        (Int32(data=-2), "fe ff ff ff"),
        (Empty(), "00"),
        (Time(sec=1, nanosec=2), "01 00 00 00 02 00 00 00"),
    ],
)
def test_a_message_is_written_as_ros_2_writes_it(message: Message, expected: str) -> None:
    assert message_to_cdr(message) == hexed(expected)


def test_each_value_is_aligned_to_its_own_size() -> None:
    message = Mixed(
        flag=True,
        number=1.5,
        small=7,
        text="ab",
        raw=b"\x01\x02",
        count=-1,
        empty=Empty(),
        times=(Time(sec=3, nanosec=4),),
        fixed=(1.0, 2.0),
        names=("x", "yz"),
    )
    expected = (
        "01 00000000000000" + struct.pack("<d", 1.5).hex()  # the flag, 7 bytes of padding
        + "07 000000" + "03000000 616200"  # a byte, padding, the text
        + "00" + "02000000 0102"
        + "ffff" + "00" + "000000"  # the structure without fields, padding
        + "01000000 03000000 04000000"
        + "00000000" + struct.pack("<dd", 1.0, 2.0).hex()  # no length where it is fixed
        + "02000000" + "02000000 7800" + "0000" + "03000000 797a00"
    )  # fmt: skip
    assert message_to_cdr(message) == hexed(expected)


def test_a_number_too_large_for_float32_is_infinite() -> None:
    written = message_to_cdr(Precise(values=(1e300, -1e300, 0.5)))
    assert struct.unpack("<3f", written[8:]) == (math.inf, -math.inf, 0.5)


def test_an_empty_array_of_large_numbers_needs_no_padding() -> None:
    """Readers look for the next value right after the length."""
    written = message_to_cdr(Listing(values=(), after=True))
    assert written == hexed("00000000 01")


class Listing(Message, ros_type="test_msgs/msg/Listing"):
    """An array, and something after it."""

    values: tuple[float, ...]
    after: bool
