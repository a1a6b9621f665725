"""Messages as JSON in the form of rosbridge."""

import json
import math
from enum import StrEnum
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field

from homebot.devices.history_messages import HistorySeries, ReadHistoryResponse
from homebot.errors import TypeMismatchError
from homebot.messages import Bool, Empty, Float64, Int32, Log, Message, ParameterValue, String, Time
from homebot.messages import message as fields
from homebot.messages.interfaces import find_message
from homebot.messages.json import message_from_json, message_to_json, message_to_pieces, message_to_text
from homebot.messages.std_msgs import Header


class Mood(StrEnum):
    CALM = "calm"
    WILD = "wild"


class Report(Message):
    name: str
    mood: Mood
    count: fields.UInt8
    level: float
    raw: bytes
    uuid: Annotated[bytes, Field(min_length=2, max_length=2)]
    values: tuple[float, ...]
    moods: tuple[Mood, ...]
    stamp: Time
    stamps: tuple[Time, ...]


def reports() -> st.SearchStrategy[Report]:
    moods = st.sampled_from(Mood)
    real = st.floats(allow_nan=False, allow_infinity=False)
    stamps = st.builds(Time, sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 999_999_999))
    return st.builds(
        Report,
        name=st.text(),
        mood=moods,
        count=st.integers(0, 255),
        level=real,
        raw=st.binary(),
        uuid=st.binary(min_size=2, max_size=2),
        values=st.lists(real).map(tuple),
        moods=st.lists(moods).map(tuple),
        stamp=stamps,
        stamps=st.lists(stamps).map(tuple),
    )


REPORT = Report(
    name="x",
    mood=Mood.CALM,
    count=1,
    level=0.5,
    raw=b"\x00\xff",
    uuid=b"ab",
    values=(1.0,),
    moods=(Mood.WILD,),
    stamp=Time(sec=1, nanosec=2),
    stamps=(),
)


@given(reports())
def test_every_message_comes_back_from_its_json_text(report: Report) -> None:
    text = json.dumps(message_to_json(report), allow_nan=False)
    assert message_from_json(Report, json.loads(text)) == report


@given(reports())
def test_the_text_of_a_message_is_its_json_in_ascii(report: Report) -> None:
    """With fields of bytes and without, which are written in different ways."""
    for message in (report, report.stamp, String(data=report.name), Float64(data=report.level)):
        text = message_to_text(message)
        assert text.isascii()
        assert json.loads(text) == message_to_json(message)


@pytest.mark.parametrize("text", ["Küche", "客廳\U0001f4a1 \x9b2J \u202e", '\x00\x1f"\\/\x7f'])
def test_texts_in_the_text_of_a_message_are_escaped_as_everywhere(text: str) -> None:
    assert message_to_text(String(data=text)).lower() == f'{{"data":{json.dumps(text).lower()}}}'


def test_the_text_of_a_message_with_an_unchecked_value_is_as_its_json_or_none_at_all() -> None:
    assert message_to_text(Float64.of_checked(data=1)) in {'{"data":1}', '{"data":1.0}'}
    with pytest.raises(TypeMismatchError, match=r"\{1\} is not a valid message value"):
        message_to_text(String.of_checked(data={1}))
    with pytest.raises(TypeMismatchError, match="is not a valid message value"):
        message_to_text(ParameterValue.of_checked(**dict(ParameterValue(type=6)) | {"bool_array_value": [True]}))


@given(reports())
def test_the_pieces_of_a_message_are_its_text(report: Report) -> None:
    for message in (report, report.stamp, Empty()):
        assert json.loads("".join(message_to_pieces(message))) == message_to_json(message)


@pytest.mark.parametrize(("count", "pieces"), [(0, 1), (1, 1), (50, 2), (51, 2), (4478, 90)])
def test_no_piece_holds_more_than_fifty_messages(count: int, pieces: int) -> None:
    report = REPORT.model_copy(update={"stamps": (Time(sec=1, nanosec=2),) * count})
    written = list(message_to_pieces(report))
    assert len(written) == pieces
    assert max(piece.count('"sec"') for piece in written) <= 51  # and the stamp beside them
    assert json.loads("".join(written)) == message_to_json(report)


def test_long_messages_are_written_in_more_pieces() -> None:
    series = HistorySeries(
        device="meter", name="meter", part="", capability="power", times=(1.0,) * 5000, values=(0.5,) * 5000
    )
    history = ReadHistoryResponse(success=True, series=(series,) * 50)
    written = list(message_to_pieces(history))
    assert max(map(len, written)) < 2 * len(message_to_text(series)) + 50_000
    assert json.loads("".join(written)) == message_to_json(history)


def test_bytes_are_base64_text_and_times_are_objects() -> None:
    assert message_to_json(REPORT) == {
        "name": "x",
        "mood": "calm",
        "count": 1,
        "level": 0.5,
        "raw": "AP8=",
        "uuid": "YWI=",
        "values": [1.0],
        "moods": ["wild"],
        "stamp": {"sec": 1, "nanosec": 2},
        "stamps": [],
    }


def test_a_message_without_fields_is_an_empty_object() -> None:
    assert message_to_json(Empty()) == {}
    assert message_from_json(Empty, {}) == Empty()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_json_has_no_number_for_is_null(value: float) -> None:
    assert message_to_json(Float64(data=value)) == {"data": None}
    assert message_to_text(Float64(data=value)) == '{"data":null}'
    assert message_to_json(ParameterValue(type=8, double_array_value=(value,)))["double_array_value"] == [None]


def test_a_value_that_was_smuggled_past_the_check_is_not_written() -> None:
    with pytest.raises(TypeMismatchError, match=r"\{1\} is not a valid message value"):
        message_to_json(String.model_construct(data={1}))  # type: ignore[arg-type]  # the mistake under test


def test_null_is_read_as_not_a_number() -> None:
    assert math.isnan(message_from_json(Float64, {"data": None}).data)
    values = message_from_json(ParameterValue, {"type": 8, "double_array_value": [None, 1.5]}).double_array_value
    assert math.isnan(values[0])
    assert values[1] == 1.5


@pytest.mark.parametrize("spelling", ["AP8=", [0, 255]])
def test_bytes_are_read_from_base64_or_a_list(spelling: object) -> None:
    assert message_from_json(Report, message_to_json(REPORT) | {"raw": spelling}) == REPORT


def test_a_whole_number_is_read_as_a_real_one() -> None:
    assert message_from_json(Float64, {"data": 3}).data == 3.0


@pytest.mark.parametrize(
    ("message_type", "value", "problem"),
    [
        (String, {}, "not a std_msgs/msg/String: field 'data' is missing"),
        (String, {"data": "x", "extra": 1}, "not a std_msgs/msg/String: field 'extra' is unknown"),
        (String, {"data": 1}, "field 'data': input should be a valid string, got 1"),
        (String, {"data": None}, "field 'data': input should be a valid string, got None"),
        (Bool, {"data": 1}, "field 'data': input should be a valid boolean, got 1"),
        (Int32, {"data": 2**31}, "field 'data': input should be less than 2147483648, got 2147483648"),
        (Int32, {"data": 1.0}, "field 'data': input should be a valid integer, got 1.0"),
        (Int32, {"data": None}, "field 'data': input should be a valid integer, got None"),
        (String, {"data": "\ud800"}, r"field 'data': input should be a valid string, got b'\xed\xa0\x80'"),
        (Header, {"stamp": 5, "frame_id": ""}, "field 'stamp' is an object with fields of its own, got 5"),
        (String, ["x"], "not a std_msgs/msg/String: expected an object, got ['x']"),
        (String, {"data": ["x" * 100]}, f"got ['{'x' * 55}..."),
    ],
)
def test_a_refusal_names_the_field_and_the_value(message_type: type[Message], value: object, problem: str) -> None:
    with pytest.raises(TypeMismatchError) as caught:
        message_from_json(message_type, value)  # type: ignore[arg-type]  # what a peer sends has any shape
    assert problem in str(caught.value)


@pytest.mark.parametrize("spelling", ["?", "AP8", "AP8=\n", "ä", [256], [-1], ["x"], [0.5], 7, None, {"a": 1}])
def test_bytes_that_are_neither_base64_nor_numbers_are_refused(spelling: object) -> None:
    with pytest.raises(TypeMismatchError) as caught:
        message_from_json(
            find_message("std_msgs/msg/UInt8MultiArray"), {"layout": {"dim": [], "data_offset": 0}, "data": spelling}
        )
    assert str(caught.value) == (
        "not a std_msgs/msg/UInt8MultiArray: field 'data': "
        f"bytes are base64 text or a list of 0 to 255, got {spelling!r}"
    )


def test_a_refusal_inside_a_nested_message_names_the_whole_path() -> None:
    line = {
        "stamp": {"sec": "x", "nanosec": 0},
        "level": 20,
        "name": "",
        "msg": "",
        "file": "",
        "function": "",
        "line": 0,
    }
    with pytest.raises(TypeMismatchError, match=r"not a rcl_interfaces/msg/Log: field 'stamp\.sec': .*, got 'x'"):
        message_from_json(Log, line)
    with pytest.raises(TypeMismatchError, match=r"field 'stamps\.1\.nanosec' is missing"):
        message_from_json(Report, {**message_to_json(REPORT), "stamps": [{"sec": 0, "nanosec": 0}, {"sec": 1}]})
    with pytest.raises(TypeMismatchError, match=r"field 'stamp' is an object with fields of its own, got 5"):
        message_from_json(Log, {**line, "stamp": 5})


def test_a_choice_outside_its_list_is_refused() -> None:
    with pytest.raises(TypeMismatchError, match=r"field 'mood': .*, got 'sad'"):
        message_from_json(Report, {**message_to_json(REPORT), "mood": "sad"})


def test_an_array_that_is_no_list_is_refused() -> None:
    with pytest.raises(TypeMismatchError, match=r"field 'values': .*, got 1\.0"):
        message_from_json(Report, {**message_to_json(REPORT), "values": 1.0})


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text() | st.sampled_from(["sec", "stamp", "raw"]), inner),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(list(Report.model_fields)), json_values))
def test_any_json_becomes_a_message_or_a_clear_refusal(value: dict[str, object]) -> None:
    whole = {**message_to_json(REPORT), **value}
    try:
        message = message_from_json(Report, whole)
    except TypeMismatchError as exc:
        message, problem = None, str(exc)
    else:
        problem = ""
    assert isinstance(message, Report) or "field '" in problem


def test_characters_are_base64_text_and_may_come_as_a_list() -> None:
    """As the original bridge sends and takes them."""

    class Line(Message, ros_type="test_msgs/msg/Line"):
        text: fields.CharArray
        code: Annotated[fields.CharArray, Field(min_length=2, max_length=2)]

    line = message_from_json(Line, {"text": "aGk=", "code": [1, 2]})
    assert message_to_json(line) == {"text": "aGk=", "code": "AQI="}
    assert json.loads(message_to_text(line)) == json.loads("".join(message_to_pieces(line))) == message_to_json(line)
    with pytest.raises(TypeMismatchError, match="field 'text'"):
        message_from_json(Line, {"text": "!", "code": [1, 2]})
