"""A byte stream becomes frames."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.turns import slowness

from homebot.errors import WireError
from homebot.mqtt.client.link import FrameReader
from homebot.mqtt.client.receiver import Frame
from homebot.mqtt.packets.primitives import encode_varint

PLAIN = bytes.fromhex("30 05 00 03") + b"a/b"


def only(data: bytes) -> Frame:
    (frame,) = FrameReader(1000).feed(data)
    return frame


def test_the_identifier_of_a_cut_packet_is_none_rather_than_wrong() -> None:
    assert Frame(0x32, bytes.fromhex("00 01 61 05")).packet_id() == 0
    assert Frame(0x32, b"").packet_id() == 0


def test_a_frame_over_the_limit_is_skipped_but_its_head_is_kept() -> None:
    big = b"\x32\xd0\x0f" + b"\x00\x01a\x00\x07" + b"x" * 1995
    reader = FrameReader(1024)
    frames = [frame for piece in (big[:700], big[700:1500], big[1500:] + PLAIN) for frame in reader.feed(piece)]
    assert [frame.oversize for frame in frames] == [2000, 0]
    assert frames[0].packet_id() == 7
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


def _length(size: int) -> bytes:
    return bytes([size]) if size < 128 else bytes([size & 0x7F | 0x80, size >> 7])
