"""Arrays of numbers are held as machine numbers, and read as the tuples that they were."""

import json
from array import array
from collections.abc import Callable
from typing import Any

import pytest
from tests.call_counts import calls

from homebot.errors import TypeMismatchError
from homebot.messages.cdr import message_to_cdr
from homebot.messages.interfaces import find_message
from homebot.messages.json import message_from_json, message_to_pieces, message_to_text
from homebot.messages.message import Message
from homebot.messages.nav_msgs import OccupancyGrid
from homebot.messages.numeric_array import NumericArray

Float32MultiArray: Any = find_message("std_msgs/msg/Float32MultiArray")
Int8MultiArray: Any = find_message("std_msgs/msg/Int8MultiArray")
Int16MultiArray: Any = find_message("std_msgs/msg/Int16MultiArray")
LAYOUT = find_message("std_msgs/msg/MultiArrayLayout").model_validate({"dim": (), "data_offset": 0})
PLAIN_LAYOUT = {"dim": [], "data_offset": 0}


@pytest.mark.parametrize(
    "value",
    [(1, -2), [1, -2], array("h", [1, -2]), array("q", [1, -2]), b"\x01\x00\xfe\xff", NumericArray("h", [1, -2])],
)
def test_numbers_come_in_every_form_and_are_read_as_a_tuple(value: Any) -> None:
    data = Int16MultiArray(layout=LAYOUT, data=value).data
    assert data == (1, -2)
    assert (data[0], data[-1], data[:1], list(data), len(data), repr(data)) == (1, -2, (1,), [1, -2], 2, "(1, -2)")


def test_equal_numbers_are_equal_messages_with_one_hash() -> None:
    one, other = (Int16MultiArray(layout=LAYOUT, data=data) for data in ((1, 2), [1, 2]))
    assert one == other
    assert len({one, other}) == 1
    assert hash(one.data) == hash((1, 2))
    assert one != Int16MultiArray(layout=LAYOUT, data=(1, 3))


def test_the_numbers_of_a_message_do_not_change() -> None:
    given = array("h", [1, 2])
    message = Int16MultiArray(layout=LAYOUT, data=given)
    given[0] = 7
    assert message.data == (1, 2)
    with pytest.raises(TypeError):
        message.data[0] = 7
    with pytest.raises(TypeError):
        message.data.buffer[0] = 7


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        ([1, 128], "field 'data.1': input should be less than 128, got 128"),
        ([1, 2, -129], "field 'data.2': input should be greater than or equal to -128, got -129"),
        ([0.5], "field 'data.0': input should be a valid integer, got 0.5"),
        (["1"], "field 'data.0': input should be a valid integer, got '1'"),
        (7, "field 'data': input should be a valid tuple, got 7"),
    ],
)
def test_a_number_that_does_not_fit_is_named(data: object, problem: str) -> None:
    with pytest.raises(TypeMismatchError) as caught:
        message_from_json(Int8MultiArray, {"layout": PLAIN_LAYOUT, "data": data})
    assert str(caught.value) == f"not a std_msgs/msg/Int8MultiArray: {problem}"


def test_bytes_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match="3 bytes are not a whole number of int16, which has 2"):
        Int16MultiArray(layout=LAYOUT, data=b"abc")


def test_real_numbers_keep_their_precision_until_they_are_written() -> None:
    message = message_from_json(Float32MultiArray, {"layout": PLAIN_LAYOUT, "data": [0.1, None, 1e300]})
    assert message.data[0] == 0.1
    assert json.loads(message_to_text(message))["data"] == [0.1, None, 1e300]
    assert message_to_cdr(message)[-12:].hex() == "cdcccc3d" + "0000c07f" + "0000807f"


def test_a_large_map_takes_no_python_code_for_each_cell() -> None:
    """A map of 384x384 took 190 ms of the loop; other clients wait meanwhile."""
    pose = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    time = {"sec": 0, "nanosec": 0}
    info = {"map_load_time": time, "resolution": 0.05, "width": 384, "height": 384, "origin": pose}
    cells = [-1, 0, 100] * (384 * 384 // 3)
    spelling = {"header": {"stamp": time, "frame_id": "map"}, "info": info, "data": cells}
    grid = message_from_json(OccupancyGrid, spelling)
    assert grid.data == tuple(cells)
    assert json.loads(message_to_text(grid)) == json.loads("".join(message_to_pieces(grid))) == spelling
    ways: tuple[Callable[[], object], ...] = (
        lambda: message_from_json(OccupancyGrid, spelling),
        lambda: message_to_text(grid),
        lambda: list(message_to_pieces(grid)),
        lambda: message_to_cdr(grid),
    )
    assert max(map(calls, ways)) < 1000


def test_a_message_with_unchecked_numbers_is_written_too() -> None:
    message: Message = Int8MultiArray.of_checked(layout=LAYOUT, data=(1, 2))
    assert json.loads(message_to_text(message))["data"] == [1, 2]
    assert message_to_cdr(message)[-2:] == b"\x01\x02"
