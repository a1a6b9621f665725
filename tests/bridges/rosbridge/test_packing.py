"""Frames as PNG images and in fragments, both ways: whoever puts them together has what was sent."""

import base64
import json
import struct
import zlib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.bridges.conftest import House, Peer
from tests.bridges.frames import result_of

from homebot.bridges.rosbridge.packing import PLAIN, FrameAssembler, Packing
from homebot.bridges.rosbridge.protocol import FrameError, SetLevel
from homebot.graph import qos_profile_latched
from homebot.messages import SetBool, String
from homebot.messages.std_srvs import SetBoolResponse


def ignore(_: int) -> None:
    """Keep no account."""


SET_LEVEL = '{"op": "set_level", "level": "warning"}'


def content(frame: dict[str, Any]) -> str:
    """Return what the image in a frame holds, read as the PNG specification says (RGB, rows without filters)."""
    assert frame["op"] == "png"
    image, chunks = base64.b64decode(frame["data"]), {}
    at = 8
    while at < len(image):
        (size,) = struct.unpack_from(">I", image, at)
        kind, data = image[at + 4 : at + 8], image[at + 8 : at + 8 + size]
        assert struct.unpack_from(">I", image, at + 8 + size) == (zlib.crc32(kind + data),)
        chunks[kind] = data
        at += size + 12
    assert image[:8] == b"\x89PNG\r\n\x1a\n"
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, *layout = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert layout == [8, 2, 0, 0, 0]
    pixels, row = zlib.decompress(chunks[b"IDAT"]), 3 * width + 1
    assert len(pixels) == row * height
    rows = [pixels[start : start + row] for start in range(0, len(pixels), row)]
    assert {one[0] for one in rows} == {0}
    return b"".join(one[1:] for one in rows).decode()


def joined(frames: list[dict[str, Any]]) -> str:
    """Return what *frames* are the fragments of."""
    assert [(one["op"], one["num"], one["total"]) for one in frames] == [
        ("fragment", number, len(frames)) for number in range(len(frames))
    ]
    assert {one["id"] for one in frames} == {frames[0]["id"]}
    return "".join(one["data"] for one in frames)


def packed(packing: Packing, text: str) -> list[dict[str, Any]]:
    return [json.loads(part) for part in packing.pack(text, "fragment:1")]


@given(st.integers(0, 3000))
def test_an_image_holds_the_frame_and_line_feeds(size: int) -> None:
    text = json.dumps({"op": "publish", "msg": "x" * size})
    (frame,) = packed(Packing(as_png=True), text)
    assert content(frame).rstrip("\n") == text


def test_the_image_is_about_square() -> None:
    """Browsers read no image of millions of pixels in a row."""
    (frame,) = packed(Packing(as_png=True), "x" * 300_000)
    assert struct.unpack_from(">II", base64.b64decode(frame["data"]), 16) == (316, 317)


def test_a_text_that_takes_long_to_compress_is_sent_as_json() -> None:
    assert list(Packing(as_png=True).pack("x" * 1_048_577, "fragment:1")) == ["x" * 1_048_577]


@given(st.text(min_size=1, max_size=300), st.integers(1, 310))
def test_fragments_have_the_size_that_was_asked_for(text: str, size: int) -> None:
    whole = json.dumps({"op": "publish", "msg": text})
    frames = packed(Packing(fragment_size=size), whole)
    if len(whole) <= size:
        assert frames == [json.loads(whole)]
    else:
        assert joined(frames) == whole
        assert {len(one["data"]) for one in frames[:-1]} == {size}


def test_a_frame_has_a_thousand_fragments_at_most() -> None:
    frames = packed(Packing(fragment_size=1), "x" * 2500)
    assert joined(frames) == "x" * 2500
    assert len(frames) == 834


@pytest.mark.parametrize("packing", [PLAIN, Packing(fragment_size=-5)])
def test_without_a_wish_a_frame_is_sent_as_it_is(packing: Packing) -> None:
    assert list(packing.pack(SET_LEVEL, "fragment:1")) == [SET_LEVEL]


@given(st.permutations(range(5)))
def test_an_operation_is_read_from_fragments_in_any_order(order: list[int]) -> None:
    reader = FrameAssembler(1000, ignore)
    fragments = list(Packing(fragment_size=8).pack(SET_LEVEL, "mine"))
    *early, last = (result_of(reader.read(fragments[number])) for number in order)
    assert early == [None] * 4
    assert isinstance(last, SetLevel)


def test_fragments_of_two_frames_may_be_mixed() -> None:
    reader = FrameAssembler(1000, ignore)
    read = [
        result_of(reader.read(one))
        for pair in zip(Packing(False, 20).pack(SET_LEVEL, "a"), Packing(False, 20).pack(SET_LEVEL, "b"), strict=True)
        for one in pair
    ]
    assert [isinstance(one, SetLevel) for one in read] == [False, False, True, True]


def fragment(number: int, total: int, data: str = "x", identifier: str = "f") -> str:
    return json.dumps({"op": "fragment", "id": identifier, "data": data, "num": number, "total": total})


@pytest.mark.parametrize(
    ("frames", "problem"),
    [
        ([fragment(2, 2)], "number 2 of 2 does not fit"),
        ([fragment(0, 2), fragment(1, 3)], "number 1 of 3 does not fit"),
        ([fragment(0, 3, "x" * 60), fragment(1, 3, "x" * 41)], "more than 100 characters"),
        ([fragment(0, 1, "x" * 101)], "more than 100 characters"),
        ([fragment(0, 9, "x" * 60, "a"), fragment(0, 9, "x" * 41, "b")], "more than 100 characters"),
        ([fragment(0, 1, fragment(0, 1))], "cannot be made of fragments"),
        ([fragment(0, 1, "no json")], "is not JSON"),
    ],
)
def test_fragments_that_do_not_fit_are_refused(frames: list[str], problem: str) -> None:
    reader = FrameAssembler(100, ignore)
    *early, last = frames
    for frame in early:
        result_of(reader.read(frame))
    with pytest.raises(FrameError, match=problem):
        result_of(reader.read(last))


def test_a_fragment_that_comes_twice_counts_once() -> None:
    reader = FrameAssembler(100, ignore)
    for _ in range(50):
        result_of(reader.read(fragment(0, 2, SET_LEVEL[:20])))
    assert isinstance(result_of(reader.read(fragment(1, 2, SET_LEVEL[20:]))), SetLevel)


def test_of_too_many_frames_that_do_not_end_the_oldest_is_forgotten() -> None:
    reader = FrameAssembler(1000, ignore)
    for number in range(11):
        result_of(reader.read(fragment(0, 2, SET_LEVEL[:20], f"{number}")))
    assert reader.dropped == 1
    assert result_of(reader.read(fragment(1, 2, SET_LEVEL[20:], "0"))) is None
    assert isinstance(result_of(reader.read(fragment(1, 2, SET_LEVEL[20:], "10"))), SetLevel)


def test_the_characters_of_kept_fragments_are_counted_until_their_frame_is_whole_or_forgotten() -> None:
    held: list[int] = []
    reader = FrameAssembler(1000, held.append)
    for frame, total in (
        (fragment(0, 2, "x" * 50, "a"), 50),
        (fragment(0, 2, SET_LEVEL[:10], "b"), 60),
        (fragment(0, 2, "é" * 50, "a"), 210),
        (fragment(1, 2, SET_LEVEL[10:], "b"), 200),
    ):
        result_of(reader.read(frame))
        assert sum(held) == total
    with pytest.raises(FrameError):
        result_of(reader.read(fragment(1, 3, "x", "a")))
    assert sum(held) == 0


async def test_a_client_gets_messages_and_responses_as_it_asked_for_them(house: House, peer: Peer) -> None:
    node = house.node("lamp")
    node.create_publisher(String, "/state", qos_profile_latched).publish(String(data="on"))
    node.create_service(SetBool, "/switch", lambda _: SetBoolResponse(success=True, message="x" * 300))
    await peer.send("subscribe", topic="/state", compression="png")
    expected: dict[str, Any] = {"op": "publish", "topic": "/state", "msg": {"data": "on"}}
    assert json.loads(content(await peer.receive())) == expected
    await peer.send("subscribe", id="b", topic="/state", fragment_size=100)
    await peer.send("subscribe", id="c", topic="/state", fragment_size=1000)
    for _ in range(2):
        first = await peer.receive()
        rest = [await peer.receive() for _ in range(first["total"] - 1)]
        assert json.loads(content(json.loads(joined([first, *rest])))) == expected
    await peer.send("call_service", id="1", service="/switch", args={"data": True}, fragment_size=200)
    response = json.loads(joined([await peer.receive() for _ in range(3)]))
    assert (response["id"], response["values"]["message"]) == ("1", "x" * 300)
    await peer.send("call_service", id="2", service="/switch", args={"data": True}, compression="png")
    assert json.loads(content(await peer.receive()))["id"] == "2"


async def test_roslibpy_is_sent_json_in_place_of_an_image(house: House) -> None:
    """It offers ``compression="png"``, and knows no frame of that kind."""
    async with house.peer(**{"User-Agent": "AutobahnPython/25.10.2"}) as peer:
        house.node("lamp").create_publisher(String, "/state", qos_profile_latched).publish(String(data="on"))
        await peer.send("subscribe", topic="/state", compression="png")
        assert (await peer.receive())["msg"] == {"data": "on"}
        await peer.send("call_service", id="t", service="/rosapi/get_time", compression="png")
        assert (await peer.receive())["op"] == "service_response"


async def test_a_client_may_send_fragments(house: House, peer: Peer) -> None:
    subscription = house.node("lamp").create_subscription(String, "/say")
    frame = json.dumps({"op": "publish", "topic": "/say", "msg": {"data": "a long word"}})
    for part in Packing(fragment_size=10).pack(frame, "mine"):
        await peer.connection.send(part)
    assert (await subscription.receive()).data == "a long word"
