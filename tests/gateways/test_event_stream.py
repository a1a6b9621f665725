"""Server-sent events, as section 9.2 of the HTML Living Standard has them."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import WireError
from homebot.gateways.event_stream import EventStreamParser, ServerEvent


def events(*chunks: bytes, max_event: int = 1000) -> list[ServerEvent]:
    parser = EventStreamParser(max_event)
    return [event for chunk in chunks for event in parser.feed(chunk)]


def test_lines_of_data_are_joined() -> None:
    """The standard's first example."""
    stream = b"data: YHOO\ndata: +2\ndata: 10\n\n"
    assert events(stream) == [ServerEvent("message", "YHOO\n+2\n10")]


def test_comments_and_ids_are_ignored_and_blanks_may_be_missing() -> None:
    """The standard's second example: the third event's data begins with a blank, and the last is never ended."""
    stream = b": test stream\n\ndata: first event\nid: 1\n\ndata:second event\nid\n\ndata:  third event\n\ndata: x\n"
    assert events(stream) == [
        ServerEvent("message", "first event"),
        ServerEvent("message", "second event"),
        ServerEvent("message", " third event"),
    ]


def test_empty_data_is_an_event_and_no_data_is_none() -> None:
    """The standard's third and fourth examples."""
    assert events(b"data\n\ndata\ndata\n\ndata:") == [ServerEvent("message", ""), ServerEvent("message", "\n")]
    assert events(b"data:test\n\ndata: test\n\n") == [ServerEvent("message", "test")] * 2
    assert events(b"event: thing_created\n\n") == []


def test_events_have_types() -> None:
    stream = b'\xef\xbb\xbfevent: thing_created\r\nid: 7\r\ndata: {"id":"urn:x"}\r\n\r\ndata: more\r\n\r\n'
    assert events(stream) == [ServerEvent("thing_created", '{"id":"urn:x"}'), ServerEvent("message", "more")]


@pytest.mark.parametrize(
    "stream", [b"data: " + b"x" * 200, b"data: x\n" * 60, b"x" * 101, b"x" * 60 + b"\n" + b"y" * 60]
)
def test_an_event_that_is_too_long_ends_the_stream(stream: bytes) -> None:
    with pytest.raises(WireError, match="longer than 100 bytes"):
        events(*(stream[at : at + 16] for at in range(0, len(stream), 16)), max_event=100)


@given(
    stream=st.lists(
        st.sampled_from(
            [b"data: a", b"data", b"event: b", b"id: 1", b":", b"\r", b"\n", b"\r\n", "é".encode(), b"\xff"]
        )
    ).map(b"".join),
    cuts=st.lists(st.integers(0, 100)),
)
def test_any_stream_means_the_same_however_it_is_cut(stream: bytes, cuts: list[int]) -> None:
    """A line feed that follows a carriage return is part of the same end of line, also in the next chunk."""
    places = sorted({0, len(stream), *(at for at in cuts if at < len(stream))})
    chunks = [stream[start:end] for start, end in pairwise(places)]
    assert events(*chunks) == events(stream)
