"""Messages for clients that want them in CBOR: roslibjs for speed, Foxglove always."""

from typing import Any

import anyio
import cbor2
import pytest
from tests.patience import PATIENCE

from homebot.bridges.rosbridge.binary_frames import publish_cbor, publish_cbor_raw
from homebot.messages import String, Time
from homebot.messages import message as fields
from homebot.messages.cdr import message_to_cdr
from homebot.messages.message import Message


class Scan(Message, ros_type="test_msgs/msg/Scan"):
    """Arrays of numbers, and what else a message may hold."""

    stamp: Time
    ranges: tuple[float, ...]
    rough: tuple[fields.Float32, ...]
    steps: tuple[fields.UInt16, ...]
    flags: tuple[bool, ...]
    raw: bytes
    text: fields.CharArray
    names: tuple[str, ...]


SCAN = Scan(
    stamp=Time(sec=1, nanosec=2),
    ranges=(1.0, 2.5),
    rough=(0.5, 1e300),
    steps=(1, 256),
    flags=(True, False),
    raw=b"\x00\xff",
    text=b"hi",
    names=("é",),
)


async def receive_binary(peer: Any) -> dict[str, Any]:
    with anyio.fail_after(PATIENCE):
        frame = await peer.connection.recv()
    assert isinstance(frame, bytes)
    decoded: dict[str, Any] = cbor2.loads(frame)
    return decoded


def test_numbers_of_one_type_are_packed_and_everything_else_is_plain() -> None:
    """The tags are those of RFC 8746 that roslibjs makes typed arrays of: 85, 86 and 69.

    A number too large for ``float32`` is infinite, as in CDR.
    """
    frame = cbor2.loads(publish_cbor("/scan", SCAN))
    assert (frame["op"], frame["topic"]) == ("publish", "/scan")
    message = frame["msg"]
    assert message.pop("ranges") == cbor2.CBORTag(86, bytes.fromhex("000000000000f03f0000000000000440"))
    assert message.pop("rough") == cbor2.CBORTag(85, bytes.fromhex("0000003f0000807f"))
    assert message.pop("steps") == cbor2.CBORTag(69, b"\x01\x00\x00\x01")
    assert message == {
        "stamp": {"sec": 1, "nanosec": 2},
        "flags": [True, False],
        "raw": b"\x00\xff",
        "text": b"hi",
        "names": ["é"],
    }


def test_losses_are_reported_in_both_forms() -> None:
    time = Time(sec=1, nanosec=2)
    raw = cbor2.loads(publish_cbor_raw("/t", String(data="x"), time, 3))
    assert raw == {
        "op": "publish",
        "topic": "/t",
        "msg": {"secs": 1, "nsecs": 2, "bytes": message_to_cdr(String(data="x"))},
        "lost": 3,
    }
    assert cbor2.loads(publish_cbor("/t", String(data="x"), 2))["lost"] == 2


async def test_a_client_that_asks_for_cbor_gets_binary_frames_and_no_remark(open_house: Any) -> None:
    async with open_house() as house, house.peer() as peer:
        publisher = house.node("talker").create_publisher(Scan, "/scan")
        await peer.send("set_level", level="info")
        await peer.tell("subscribe", topic="/scan", compression="cbor")
        publisher.publish(SCAN)
        frame = await receive_binary(peer)
    assert (frame["op"], frame["topic"], frame["msg"]["raw"]) == ("publish", "/scan", b"\x00\xff")


async def test_a_client_that_asks_for_cbor_raw_gets_the_bytes_of_ros_2_and_the_time(open_house: Any) -> None:
    """Foxglove subscribes to nothing else, and reads the bytes with the texts of ``/rosapi/topics_and_raw_types``."""
    async with open_house() as house, house.peer() as peer:
        publisher = house.node("talker").create_publisher(String, "/chatter")
        await peer.tell("subscribe", topic="chatter", compression="cbor-raw")
        before = house.graph.clock.now()
        publisher.publish(String(data="hi"))
        frame = await receive_binary(peer)
    assert (frame["op"], frame["topic"]) == ("publish", "chatter")
    assert frame["msg"]["bytes"] == message_to_cdr(String(data="hi"))
    assert frame["msg"]["secs"] + frame["msg"]["nsecs"] * 1e-9 >= before - 1e-6


@pytest.mark.parametrize("first", ["none", "cbor"])
async def test_of_several_requests_the_most_compact_form_is_sent_until_it_is_withdrawn(
    open_house: Any, first: str
) -> None:
    async with open_house() as house, house.peer() as peer:
        publisher = house.node("talker").create_publisher(String, "/chatter")
        await peer.send("subscribe", id="a", topic="/chatter", compression=first)
        await peer.tell("subscribe", id="b", topic="/chatter", compression="cbor-raw")
        publisher.publish(String(data="1"))
        assert "bytes" in (await receive_binary(peer))["msg"]
        await peer.tell("unsubscribe", id="b", topic="/chatter")
        publisher.publish(String(data="2"))
        message = (await peer.receive() if first == "none" else await receive_binary(peer))["msg"]
    assert message == {"data": "2"}
