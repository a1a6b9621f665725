"""The format of recordings: what is written is read again, and a wrong line is named."""

import gzip
import json
import re
from pathlib import Path

import pytest

from homebot.devices import RawMessage
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.value import Value
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.messages.message import Message
from homebot.recording.lines import (
    GatewayNews,
    LostLines,
    RecordedCommand,
    RecordingEnd,
    RecordingHeader,
    RecordingLine,
    line_text,
    read_line,
)
from homebot.recording.recording import load_recording, read_recording

AT = Time(sec=1_767_225_600, nanosec=0)
HEADER = RecordingHeader(format=2, version="1.0", home="home", started_at=AT)
RAW = RawMessage(
    gateway="mqtt",
    key="lights/lamp",
    address="home/lights/lamp/out",
    payload=b"\x00\xff on",
    retained=False,
    received_at=Time(sec=1_767_225_601, nanosec=5),
)
COMMAND = RecordedCommand(id="c-1", issuer="/app", device="lights/lamp", text="off")
RESULT = CommandResult(command_id="c-1", outcome="refused", text="refused by rights", policy="rights", reason="no")


def lines(*messages: tuple[float, Message]) -> list[bytes]:
    return [line_text(RecordingLine(at, message)).encode() for at, message in messages]


@pytest.mark.parametrize("message", [HEADER, RAW, COMMAND, RESULT, LostLines(count=3), RecordingEnd(reason="full")])
def test_a_line_is_read_as_it_was_written(message: Message) -> None:
    line = RecordingLine(12.345678, message)
    text = line_text(line)
    assert read_line(text) == line
    assert text.isascii()
    assert "\n" not in text


def test_a_recording_is_sorted_by_time_and_outcomes_find_their_commands() -> None:
    found = read_recording(lines((0, HEADER), (5, COMMAND), (3, RAW), (9, RESULT), (10, LostLines(count=2))), "day")
    assert [one.message for one in found.events] == [RAW]
    assert [(one.at, one.command, one.result) for one in found.commands] == [(5.0, COMMAND, RESULT)]
    assert (found.lost, found.ends_at, found.gateways) == (2, 10.0, ("mqtt",))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "day, line 2: is not JSON"),
        ("{", "day, line 2: is not JSON"),
        ("[1]", "day, line 2: must be a JSON object with the fields 'at', 'kind' and 'message'"),
        ('{"at":1,"kind":"raw"}', "day, line 2: must be a JSON object with the fields"),
        (
            '{"at":"1","kind":"raw","message":{}}',
            "day, line 2: field 'at': must be a number of seconds within 366 days, got '1'",
        ),
        ('{"at":true,"kind":"raw","message":{}}', "day, line 2: field 'at'"),
        ('{"at":NaN,"kind":"raw","message":{}}', "day, line 2: field 'at'"),
        ('{"at":1,"kind":"row","message":{}}', "day, line 2: field 'kind': must be one of recording, index, device"),
        ('{"at":1,"kind":["raw"],"message":{}}', "day, line 2: field 'kind'"),
        ('{"at":1,"kind":"lost","message":{}}', "day, line 2: field 'message': .*field 'count' is missing"),
        ('{"at":1,"kind":"lost","message":{"count":-1}}', "day, line 2: field 'message': .*'count'.*got -1"),
        (
            '{"at":4e7,"kind":"lost","message":{"count":1}}',
            "day, line 2: field 'at': .* within 366 days, got '40000000.0'",
        ),
        ('{"at":1,"at":2,"kind":"lost","message":{"count":1}}', "day, line 2: is not JSON: the key 'at' occurs twice"),
        (line_text(RecordingLine(0, HEADER)), "day, line 2: field 'kind': a recording has one header"),
    ],
)
def test_a_wrong_line_is_named_with_its_number_and_field(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        read_recording([*lines((0, HEADER)), text.encode()], "day")


def test_a_file_without_its_header_or_of_another_version_is_refused() -> None:
    with pytest.raises(UsageError, match="day is empty"):
        read_recording([], "day")
    with pytest.raises(UsageError, match=r"its first line is no header; `homebot record` makes one$"):
        read_recording(lines((0, RAW)), "day")
    with pytest.raises(UsageError, match="day, line 1: field 'kind': the first line of a recording is its header"):
        read_recording(lines((0, RecordingEnd(reason="recording"))), "day")
    problem = (
        "day, line 1: field 'message.format': is 3, but this homebot reads up to 2: replay it with a newer homebot"
    )
    with pytest.raises(UsageError, match=rf"^{re.escape(problem)}$"):
        read_recording([b'{"at": 0, "kind": "recording", "message": {"format": 3, "a_field_to_come": true}}'], "day")
    assert read_recording(lines((0, HEADER.model_copy(update={"format": 1}))), "day").header.format == 1


def test_fields_of_a_newer_homebot_are_left_out_at_every_depth() -> None:
    setting = Setting(capability="on_off", value=Value.of(True))
    command = COMMAND.model_copy(update={"settings": (setting, setting)})
    newer = json.loads(line_text(RecordingLine(1, command)))
    message = newer["message"]
    for place in (newer, message, message["trigger"], *message["settings"]):
        place["newer"] = {"a": [None]}
    found = read_recording([*lines((0, HEADER)), json.dumps(newer).encode()], "day")
    assert [one.command for one in found.commands] == [command]


def test_nothing_comes_after_the_end() -> None:
    with pytest.raises(UsageError, match="day, line 3: comes after the end"):
        read_recording(lines((0, HEADER), (1, RecordingEnd()), (2, RAW)), "day")


def test_a_compressed_file_that_is_damaged_is_refused(tmp_path: Path) -> None:
    whole = gzip.compress(b"".join(one + b"\n" for one in lines((0, HEADER), (1, RAW))))
    path = tmp_path / "day.jsonl.gz"
    path.write_bytes(whole)
    assert len(load_recording(path).events) == 1
    for damaged in (whole[:-9], b"not compressed", whole[:20] + b"\x00" * 30):
        path.write_bytes(damaged)
        with pytest.raises(UsageError, match=r"day.jsonl.gz (is damaged|ends in the middle)"):
            load_recording(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"none.jsonl cannot be read: No such file"):
        load_recording(tmp_path / "none.jsonl")


def test_a_gateway_is_one_of_a_recording_by_its_state_alone() -> None:
    news = GatewayNews.model_validate(
        {"gateway": "ble", "state": {"state": "unavailable", "reason": "no radio", "acts": True}}
    )
    assert read_recording(lines((0, HEADER), (0, news)), "day").gateways == ("ble",)
