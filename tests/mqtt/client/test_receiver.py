"""The receiving half that all adapters share."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from structlog.testing import capture_logs

from homebot.clock import ManualClock
from homebot.errors import LinkError
from homebot.mqtt.client import SessionGrant
from homebot.mqtt.client.login import MqttVersion
from homebot.mqtt.client.receiver import Frame, Receiver
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Properties

BAD = Frame(0x32, b"\x00\x02\xc3\x28\x00\x07")


def make(
    clock: ManualClock | None = None,
    *,
    inbox_messages: int = 10,
    protocol: MqttVersion = "3.1.1",
    write: Callable[[bytes], object] = len,
) -> Receiver:
    receiver = Receiver(MqttOptions(host="broker", inbox_messages=inbox_messages), clock or ManualClock())
    receiver.begin_link(SessionGrant(resumed=False, protocol=protocol), write)
    return receiver


async def test_a_publish_becomes_a_message_that_can_be_acknowledged() -> None:
    written: list[bytes] = []
    receiver = make(write=written.append)
    assert receiver.publish(Frame(0x33, b"\x00\x03a/b\x12\x34x")) == b""
    receiver.deliver()
    messages = await receiver.receive()
    assert messages == [MqttMessage("a/b", b"x", 1, retain=True)]
    receiver.ack(messages)
    receiver.end_link(LinkError("lost"))
    receiver.ack(messages)
    assert written == [b"\x40\x02\x12\x34"]


async def test_a_publish_of_mqtt_5_has_properties() -> None:
    receiver = make(protocol="5")
    receiver.publish(
        Frame(
            0x32,
            bytes.fromhex(
                "00 03 61 2f 62 00 07"  # topic a/b, identifier 7
                "23 01 01 02 00 00 00 3c 03 00 02 74 70 08 00 01 72 09 00 02 ff 00"
                "26 00 01 6b 00 01 76 26 00 01 6b 00 01 77"
                "6869"
            ),
        )
    )
    receiver.deliver()
    properties = Properties(
        payload_format_indicator=1,
        message_expiry_interval=60,
        content_type="tp",
        response_topic="r",
        correlation_data=b"\xff\x00",
        user_properties=(("k", "v"), ("k", "w")),
    )
    assert await receiver.receive() == [MqttMessage("a/b", b"hi", 1, properties=properties)]


async def test_a_publish_of_qos_0_with_the_flag_of_a_repetition_is_taken() -> None:
    receiver = make()
    receiver.publish(Frame(0x38, b"\x00\x01tx"))
    receiver.deliver()
    assert await receiver.receive() == [MqttMessage("t", b"x")]


@pytest.mark.parametrize("body", ["", "00 00 03 23 00 01", "00 01 61 02 7f 00"], ids=["no topic", "alias", "property"])
def test_a_bad_publish_is_counted(body: str) -> None:
    receiver = make(protocol="5")
    assert receiver.publish(Frame(0x30, bytes.fromhex(body))) == b""
    assert receiver.counters.dropped_malformed == 1


@given(first=st.integers(0x30, 0x3F), body=st.binary(max_size=60), protocol=st.sampled_from(("5", "3.1.1")))
def test_any_bytes_are_a_message_or_counted(first: int, body: bytes, protocol: MqttVersion) -> None:
    receiver = make(protocol=protocol)
    receiver.publish(Frame(first, body))
    receiver.deliver()
    assert receiver.counters.received + receiver.counters.dropped_malformed == 1


def test_a_flood_of_bad_messages_is_counted_in_full_and_logged_now_and_then() -> None:
    clock = ManualClock()
    receiver = make(clock)
    with capture_logs() as lines:
        for _ in range(100):
            receiver.publish(BAD)
            clock.advance(0.25)
    assert receiver.counters.dropped_malformed == 100
    assert [line["malformed"] for line in lines] == [1, 41, 81]
    assert {line["event"] for line in lines} == {"mqtt.messages_dropped"}


def test_a_bad_message_is_acknowledged_or_it_would_come_for_ever() -> None:
    assert make().publish(BAD) == b"\x40\x02\x00\x07"


@pytest.mark.parametrize(
    "frame",
    [Frame(0x36, b"\x00\x01t\x00\x07"), Frame(0x32, b"\x00\x01t\x00\x00"), Frame(0x32, b"\x00\x01t\x00")],
    ids=["qos 3", "identifier 0", "cut identifier"],
)
def test_what_cannot_be_acknowledged_is_only_counted(frame: Frame) -> None:
    receiver = make()
    assert receiver.publish(frame) == b""
    assert receiver.counters.dropped_malformed == 1


async def test_a_full_inbox_is_told() -> None:
    receiver = make(inbox_messages=2)
    with capture_logs() as lines:
        for number in range(5):
            receiver.publish(Frame(0x30, b"\x00\x01t%d" % number))
        receiver.deliver()
    assert [message.payload for message in await receiver.receive()] == [b"3", b"4"]
    assert receiver.counters.received == 5
    assert receiver.counters.dropped_overflow == 3
    assert len(lines) == 1
