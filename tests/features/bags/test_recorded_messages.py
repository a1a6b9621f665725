"""Recordings of homebot as messages of topics."""

from typing import Any

from homebot.devices import GatewayState, RawMessage
from homebot.devices.command_messages import CommandResult
from homebot.features.bags.command_files import recorded_messages
from homebot.messages import Time
from homebot.messages.cdr import message_from_cdr
from homebot.recording.lines import (
    GatewayNews,
    RecordedCommand,
    RecordingEnd,
    RecordingHeader,
    RecordingLine,
    line_text,
)
from homebot.recording.recording import read_recording

START = Time(sec=1_767_225_600, nanosec=500_000_000)
HEADER = RecordingHeader(format=2, version="1", home="home", started_at=START)


def test_messages_are_on_their_topics_in_order_of_time() -> None:
    state = GatewayState(state="active", reason="", acts=True)
    raw = RawMessage(gateway="mqtt", key="lights/hall-1", address="a", payload=b"on", retained=False, received_at=START)
    command = RecordedCommand(id="c1", issuer="/app", device="lamp")
    result = CommandResult(command_id="c1", outcome="already_so", text="it was so already")
    lines = [
        RecordingLine(0.0, HEADER),
        RecordingLine(-1.0, GatewayNews(gateway="mqtt", state=state)),
        RecordingLine(2.25, command),
        RecordingLine(1.0, raw),
        RecordingLine(2.5, result),
        RecordingLine(3.0, RecordingEnd()),
    ]
    recording = read_recording([line_text(one).encode() for one in lines], "test")
    found = list(recorded_messages(recording))
    start = 1_767_225_600_500_000_000
    assert [(one.topic.name, one.at) for one in found] == [
        ("/gateway/mqtt/state", start),
        ("/gateway/mqtt/received_data/lights/hall_x2d1", start + 1_000_000_000),
        ("/recording/commands", start + 2_250_000_000),
        ("/recording/outcomes", start + 2_250_000_000),
    ]
    decoded: list[Any] = [message_from_cdr(one.topic.message_type(), one.data) for one in found]
    assert decoded[0].state == "active"
    assert decoded[1].payload == b"on"
    assert (decoded[2].id, decoded[3].text) == ("c1", "it was so already")
