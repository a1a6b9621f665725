"""A byte stream becomes frames, a PUBLISH becomes a message."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.turns import slowness

from homebot.errors import WireError
from homebot.mqtt.client.incoming import Frame, FrameReader, PublishReader
from homebot.mqtt.message import MessageProperties, MqttMessage
from homebot.mqtt.packets.primitives import encode_varint

PLAIN = bytes.fromhex("30 05 00 03") + b"a/b"
QOS_1 = bytes.fromhex("33 08 00 03") + b"a/b" + bytes.fromhex("12 34") + b"x"
PROPERTIES = bytes.fromhex(
    "32 2f 00 03 61 2f 62 00 07"  # QoS 1, topic a/b, identifier 7
    "25 01 01 02 00 00 00 3c 03 00 02 74 70 08 00 01 72 09 00 02 ff 00 26 00 01 6b 00 01 76 26 00 01 6b 00 01 77"
    "0b 05"  # a subscription identifier: legal and of no interest
    "6869"
)


def only(data: bytes) -> Frame:
    (frame,) = FrameReader(1000).feed(data)
    return frame


def test_a_plain_publish_of_3_1_1() -> None:
    message = PublishReader(has_properties=False).read(only(PLAIN), 0)
    assert message == MqttMessage("a/b", b"")


def test_a_retained_publish_of_qos_1() -> None:
    reader, frame = PublishReader(has_properties=False), only(QOS_1)
    assert reader.packet_id(frame) == 0x1234
    assert reader.read(frame, 99) == MqttMessage("a/b", b"x", 1, retain=True)
    assert reader.read(frame, 99).receipt == 99


def test_a_publish_with_properties() -> None:
    message = PublishReader(has_properties=True).read(only(PROPERTIES), 1)
    assert message == MqttMessage(
        "a/b",
        b"hi",
        1,
        properties=MessageProperties(
            payload_is_text=True,
            expiry=60,
            content_type="tp",
            response_topic="r",
            correlation_data=b"\xff\x00",
            user=(("k", "v"), ("k", "w")),
        ),
    )


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("", "there is no topic"),
        ("00 05 61", "the topic is longer than the packet"),
        ("00 00", "an empty topic: a topic alias, which we never allow"),
        ("00 02 c3 28", "not UTF-8"),
        ("00 03 61 2f 2b", "a wildcard"),
        ("00 03 61 00 62", "a NUL"),
        ("00 01 61", "properties are missing"),
        ("00 01 61 02 7f 00", "an unknown property"),
        ("00 01 61 05 03 00 01", "properties longer than the packet"),
    ],
)
def test_a_bad_publish_is_a_wire_error(body: str, why: str) -> None:
    frame = Frame(0x30, bytes.fromhex(body))
    with pytest.raises(WireError):
        PublishReader(has_properties=True).read(frame, 0)


def test_the_identifier_of_a_cut_packet_is_none_rather_than_wrong() -> None:
    reader = PublishReader(has_properties=False)
    assert reader.packet_id(Frame(0x32, bytes.fromhex("00 01 61 05"))) == 0
    assert reader.packet_id(Frame(0x32, b"")) == 0


def test_a_frame_over_the_limit_is_skipped_but_its_head_is_kept() -> None:
    big = b"\x32\xd0\x0f" + b"\x00\x01a\x00\x07" + b"x" * 1995
    reader = FrameReader(1024)
    frames = [frame for piece in (big[:700], big[700:1500], big[1500:] + PLAIN) for frame in reader.feed(piece)]
    assert [frame.oversize for frame in frames] == [2000, 0]
    assert PublishReader(has_properties=True).packet_id(frames[0]) == 7
    assert frames[1] == only(PLAIN)


def test_of_a_huge_frame_only_a_bounded_head_is_kept() -> None:
    reader = FrameReader(1024)
    size = 3_000_000
    length = bytes([size & 0x7F | 0x80, size >> 7 & 0x7F | 0x80, size >> 14 & 0x7F | 0x80, size >> 21])
    frames = reader.feed(b"\x30" + length)
    for _ in range(30):
        frames += reader.feed(bytes(100_000))
    assert [frame.oversize for frame in frames] == [size]
    assert len(frames[0].body) == 65_539


@pytest.mark.no_cover
def test_a_long_packet_is_not_copied_for_each_of_its_pieces() -> None:
    body = bytes(16 * 1024 * 1024)
    data = b"\x30" + encode_varint(len(body)) + body
    reader, frames = FrameReader(2 * len(body)), []

    began = time.thread_time()
    for start in range(0, len(data), 4096):
        frames += reader.feed(data[start : start + 4096])

    assert frames == [Frame(0x30, body)]
    assert time.thread_time() - began < slowness()


def test_a_length_of_five_bytes_ends_the_stream() -> None:
    with pytest.raises(WireError, match="four bytes"):
        FrameReader(1024).feed(b"\x30\xff\xff\xff\xff\x01")


@given(
    st.lists(st.tuples(st.integers(0, 255), st.binary(max_size=400))),
    st.lists(st.integers(1, 60), min_size=1),
)
def test_however_the_stream_is_cut_the_frames_are_the_same(bodies: list[tuple[int, bytes]], cuts: list[int]) -> None:
    stream = b"".join(bytes([first]) + _length(len(body)) + body for first, body in bodies)
    reader, frames, position, turn = FrameReader(1024), [], 0, 0
    while position < len(stream):
        step = cuts[turn % len(cuts)]
        frames += reader.feed(stream[position : position + step])
        position, turn = position + step, turn + 1
    assert frames == [Frame(first, body) for first, body in bodies]


@given(first=st.integers(0x30, 0x3F), body=st.binary(max_size=60), has_properties=st.booleans())
def test_any_bytes_are_a_message_or_a_wire_error(first: int, body: bytes, *, has_properties: bool) -> None:
    reader = PublishReader(has_properties=has_properties)
    assert 0 <= reader.packet_id(Frame(first, body)) <= 0xFFFF
    try:
        message = reader.read(Frame(first, body), 0)
    except WireError:
        return
    assert message.topic
    assert not {"+", "#", "\0"} & set(message.topic)


def _length(size: int) -> bytes:
    return bytes([size]) if size < 128 else bytes([size & 0x7F | 0x80, size >> 7])
