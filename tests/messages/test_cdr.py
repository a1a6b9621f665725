"""Messages in CDR, as ROS 2 writes them."""

import math
import struct
from enum import StrEnum
from random import Random
from typing import Annotated

import pytest
from pydantic import Field

from homebot.errors import TypeMismatchError
from homebot.messages import Empty, Int32, String, Time
from homebot.messages import message as fields
from homebot.messages.cdr import message_from_cdr, message_to_cdr
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


MIXED = Mixed(
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
    assert message_from_cdr(type(message), hexed(expected)) == message


def test_each_value_is_aligned_to_its_own_size() -> None:
    expected = (
        "01 00000000000000" + struct.pack("<d", 1.5).hex()  # the flag, 7 bytes of padding
        + "07 000000" + "03000000 616200"  # a byte, padding, the text
        + "00" + "02000000 0102"
        + "ffff" + "00" + "000000"  # the structure without fields, padding
        + "01000000 03000000 04000000"
        + "00000000" + struct.pack("<dd", 1.0, 2.0).hex()  # no length where it is fixed
        + "02000000" + "02000000 7800" + "0000" + "03000000 797a00"
    )  # fmt: skip
    assert message_to_cdr(MIXED) == hexed(expected)
    assert message_from_cdr(Mixed, hexed(expected)) == MIXED


def test_a_number_too_large_for_float32_is_infinite() -> None:
    written = message_to_cdr(Precise(values=(1e300, -1e300, 0.5)))
    assert struct.unpack("<3f", written[8:]) == (math.inf, -math.inf, 0.5)
    assert message_from_cdr(Precise, written).values == (math.inf, -math.inf, 0.5)


def test_an_empty_array_of_large_numbers_needs_no_padding() -> None:
    """Readers look for the next value right after the length."""
    written = message_to_cdr(Listing(values=(), after=True))
    assert written == hexed("00000000 01")


class Listing(Message, ros_type="test_msgs/msg/Listing"):
    """An array, and something after it."""

    values: tuple[float, ...]
    after: bool


class Mode(StrEnum):
    """Two values."""

    ON = "on"
    OFF = "off"


class Strict(Message, ros_type="test_msgs/msg/Strict"):
    """Values with limits."""

    mode: Mode
    few: Annotated[tuple[float, ...], Field(max_length=2)]
    numbers: fields.Float32Array
    mixed: tuple[Listing, ...]
    password: Annotated[str, Field(repr=False)]


STRICT = Strict(
    mode=Mode.OFF, few=(1.0,), numbers=(0.5, 2.0), mixed=(Listing(values=(1.0,), after=True),), password="secret"
)


def test_a_message_is_read_with_its_enumerations_arrays_and_nested_messages() -> None:
    read = message_from_cdr(Strict, message_to_cdr(STRICT))
    assert read == STRICT
    assert read.mode is Mode.OFF


@pytest.mark.parametrize(
    ("message_type", "data", "problem"),
    [
        (String, "", "field 'data': it is cut off: 0 of 4 bytes are left"),
        (String, "06000000 6865", "field 'data': it is cut off: 2 of 6 bytes are left"),
        (String, "02000000 ff00", "field 'data': byte 0 is not utf-8, got 'ff 00'"),
        (String, "01000000 00 00000000", "4 bytes are left over: the sender has another version of the type"),
        (Listing, "ffffffff 00", "field 'values': it is cut off: 1 of 34359738364 bytes are left"),
        (Listing, "00000000 07", "field 'after': a bool is 0 or 1, got 7"),
        (Strict, "04000000 6f666600 03000000", "field 'few': at most 2 elements are allowed, got 3"),
        (Strict, "03000000 6f6e0000 00000000 00000000 ffffffff", "field 'mixed': it is cut off: 0 of 4294967295 bytes"),
        (
            Strict,
            "03000000 6f6e0000 00000000 00000000 02000000 00000000 0100 0000 00000000 09",
            "field 'mixed.after': a bool is 0 or 1, got 9",
        ),
        (
            Strict,
            "03000000 617700 00 00000000 00000000 00000000 01000000 00",
            "field 'mode': input should be an instance of Mode, got 'aw'",
        ),
    ],
)
def test_what_is_wrong_is_said_with_the_field_and_the_value(
    message_type: type[Message], data: str, problem: str
) -> None:
    with pytest.raises(TypeMismatchError) as caught:
        message_from_cdr(message_type, hexed(data))
    assert str(caught.value).startswith(f"not a {message_type.ros_type} in CDR: {problem}")


@pytest.mark.parametrize("header", ["", "00 00 00 00", "00 03 00 00", "05 01 00 00"])
def test_another_encoding_is_refused(header: str) -> None:
    with pytest.raises(TypeMismatchError, match="begins with 00 01"):
        message_from_cdr(String, bytes.fromhex(header) + bytes(5))


def test_the_padding_at_the_end_is_ignored_as_the_nul_of_a_text_may_be_missing() -> None:
    assert message_from_cdr(String, hexed("02000000 6869 000000")) == String(data="hi")


def test_a_secret_is_not_shown() -> None:
    data = message_to_cdr(STRICT)[:-4] + b"\xff\xfe\xfd\xfc"
    with pytest.raises(TypeMismatchError) as caught:
        message_from_cdr(Strict, data)
    assert str(caught.value).endswith("field 'password': byte 3 is not utf-8")


@pytest.mark.parametrize("message", [MIXED, STRICT], ids=["mixed", "strict"])
def test_a_message_cut_anywhere_is_refused(message: Message) -> None:
    whole = message_to_cdr(message)
    for size in range(len(whole)):
        with pytest.raises(TypeMismatchError, match=r"cut off|begins with 00 01"):
            message_from_cdr(type(message), whole[:size])


@pytest.mark.parametrize("message", [MIXED, STRICT], ids=["mixed", "strict"])
def test_changed_bytes_are_another_message_or_are_refused(message: Message) -> None:
    random = Random(1)  # noqa: S311 - the same cases each time
    whole = message_to_cdr(message)
    refused = 0
    for _ in range(2000):
        changed = bytearray(whole)
        changed[random.randrange(4, len(changed))] = random.randrange(256)
        try:
            read = message_from_cdr(type(message), bytes(changed))
        except TypeMismatchError:
            refused += 1
        else:
            assert message_from_cdr(type(message), message_to_cdr(read)) == read or "nan" in repr(read)
    assert 0 < refused < 2000
