"""The receiving half that all adapters share."""

from __future__ import annotations

import pytest
from structlog.testing import capture_logs

from homebot.clock import ManualClock
from homebot.mqtt.client import SessionGrant
from homebot.mqtt.client.incoming import Frame
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.options import MqttOptions

BAD = Frame(0x32, b"\x00\x02\xc3\x28\x00\x07")


def make(clock: ManualClock | None = None, *, inbox_messages: int = 10) -> Receiver:
    receiver = Receiver(MqttOptions(host="broker", inbox_messages=inbox_messages), clock or ManualClock())
    receiver.begin_link(SessionGrant(resumed=False, protocol="3.1.1"))
    return receiver


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
