"""What a device says again takes little room in a recording, and is read as it was said."""

import pytest
from tests.announcements import sighting_of

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.value import Reading, Value
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.messages.message import Message
from homebot.recording.lines import RecordingLine, line_text, read_line
from homebot.recording.repetitions import Repetition, Repetitions


def at(seconds: float) -> Time:
    return Time.from_seconds(1_767_225_600 + seconds)


def sighted(seconds: float, *, key: str = "lamp", name: str = "Lamp", lasts: float = 90.0) -> Sighting:
    return sighting_of(key, name=name, address="a", command_address="b", at=1_767_225_600 + seconds, lasts=lasts)


def reported(seconds: float, *, on: bool = True, stream: str = "lamp/state") -> Report:
    reading = Reading(part="light", capability="on_off", value=Value.of(on))
    return Report(
        gateway="mqtt", key="lamp", readings=(reading,), stream=stream, retained=False, received_at=at(seconds)
    )


def written(*messages: Message) -> list[Message]:
    repetitions = Repetitions()
    return [repetitions.shortened(one) for one in messages]


def read(messages: list[Message]) -> list[Message]:
    repetitions = Repetitions()
    return [repetitions.whole(read_line(line_text(RecordingLine(0.0, one))).message) for one in messages]


def test_the_same_again_is_short_and_read_in_full() -> None:
    told: list[Message] = [sighted(0), reported(0), sighted(1.25), reported(1.25), sighted(2), reported(2)]
    short = written(*told)
    assert [type(one) for one in short] == [Sighting, Report, *[Repetition] * 4]
    assert read(short) == told


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (sighted(0), sighted(1, name="Hall")),
        (sighted(0), sighted(1, lasts=60.0)),
        (sighted(0), sighted(1, key="other")),
        (reported(0), reported(1, on=False)),
        (reported(0), reported(1, stream="lamp/level")),
    ],
    ids=["name", "lasting", "device", "value", "stream"],
)
def test_what_is_new_is_in_full(first: Message, second: Message) -> None:
    assert written(first, second) == [first, second]


def test_a_value_that_comes_back_is_new() -> None:
    told: list[Message] = [reported(0), reported(1, on=False), reported(2)]
    assert written(*told) == told


def test_after_a_loss_all_is_told_in_full() -> None:
    repetitions = Repetitions()
    repetitions.shortened(reported(0))
    repetitions.forget()
    assert repetitions.shortened(reported(1)) == reported(1)


def test_a_repetition_of_nothing_is_refused() -> None:
    lone = Repetition(of="report", gateway="mqtt", key="lamp", stream="s", at=at(0))
    with pytest.raises(UsageError, match="repeats a report of 'lamp', but there is none before"):
        Repetitions().whole(lone)


def test_the_source_that_was_silent_for_longest_is_forgotten_by_both() -> None:
    told: list[Message] = [reported(0, stream=f"s{number}") for number in range(20_001)]
    again: list[Message] = [reported(1, stream="s20000"), reported(1, stream="s0")]
    short = written(*told, *again)
    assert [type(one) for one in short[-2:]] == [Repetition, Report]
    assert read(short[-3:])[1:] == again
