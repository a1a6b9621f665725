"""Publishers wait for slow subscribers instead of losing messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from homebot.clock import ManualClock
from homebot.mqtt.broker import Hub
from homebot.mqtt.packets import (
    Connack,
    Disconnect,
    Pingreq,
    Pingresp,
    Properties,
    ProtocolVersion,
    Puback,
    Publish,
    ReasonCode,
    Will,
)

if TYPE_CHECKING:
    from tests.mqtt.broker.conftest import Join, MemoryClient, NewHub

V311 = ProtocolVersion.V311


@pytest.fixture
def small(new_hub: NewHub) -> Hub:
    """Eight messages may wait for a client: publishers are held back from the sixth on."""
    return new_hub(max_inflight=1, max_queued_messages=8, max_held_packets=20)


@pytest.fixture
def later(small: Hub, clock: ManualClock) -> Callable[[float], None]:
    def move(seconds: float) -> None:
        clock.advance(seconds)
        small.deadlines.run(clock.monotonic())

    return move


def pour(client: MemoryClient, count: int, start: int = 1) -> int:
    """Publish *count* messages at QoS 1 and return how many were acknowledged."""
    for number in range(start, start + count):
        client.publish("t", str(number).encode(), 1, number)
    return len(client.take_only(Puback))


def drain(client: MemoryClient) -> list[bytes]:
    """Acknowledge everything until nothing more comes."""
    payloads = []
    while messages := client.messages():
        payloads += [message.payload for message in messages]
        client.acknowledge(*messages)
    return payloads


def test_no_acknowledged_message_is_lost_however_slow_the_subscriber(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("t")
    assert pour(publisher, 15) == 7
    assert small.stats.queued_messages == 6
    assert drain(slow) == [str(number).encode() for number in range(1, 16)]
    assert len(publisher.take_only(Puback)) == 8
    assert small.stats.holds >= 1
    assert small.stats.dropped_overrun == 0


def test_a_held_publisher_may_still_ping_and_acknowledge(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("t")
    publisher.subscribe("mine")
    pour(publisher, 9)
    join("o", at=small).publish("mine", b"1", 1, 1)
    (message,) = publisher.messages()
    publisher.send(Puback(message.packet_id or 0), Pingreq())
    assert publisher.take() == [Pingresp()]


def test_a_client_that_floods_itself_does_not_block_itself(small: Hub, join: Join) -> None:
    client = join("both", at=small)
    client.subscribe("t")
    acknowledged = 0
    for number in range(1, 31):
        client.publish("t", b"x", 1, number)
        for packet in client.take():
            acknowledged += isinstance(packet, Puback)
            if isinstance(packet, Publish):
                client.send(Puback(packet.packet_id or 0))
    acknowledged += sum(isinstance(packet, Puback) for packet in client.take())
    assert acknowledged == 30


def test_when_too_much_waits_the_socket_is_not_read(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small, version=V311)
    slow.subscribe("t")
    pour(publisher, 7 + 19)
    assert publisher.link.reading
    publisher.publish("t", b"27", 1, 27)
    assert not publisher.link.reading
    drain(slow)
    assert publisher.link.reading
    assert small.stats.queued_messages == 0


def test_the_keep_alive_of_a_publisher_that_is_not_read_does_not_run_out(
    small: Hub, join: Join, later: Callable[[float], None]
) -> None:
    slow, publisher = join("s", at=small), join("p", at=small, keep_alive=4)
    slow.subscribe("t")
    pour(publisher, 40)
    later(6)
    assert not publisher.link.closed
    drain(slow)
    later(6)
    assert publisher.link.closed


def test_after_its_time_a_slow_subscriber_gets_only_what_it_has_room_for(
    small: Hub, join: Join, later: Callable[[float], None]
) -> None:
    slow, publisher, older = join("s", at=small), join("p", at=small), join("o", at=small, version=V311)
    slow.subscribe("t")
    pour(publisher, 12)
    later(10)
    reasons = [ack.reason for ack in publisher.take_only(Puback)]
    assert reasons == [ReasonCode.SUCCESS] * 2 + [ReasonCode.QUOTA_EXCEEDED] * 3
    assert pour(older, 2, start=100) == 2
    assert small.stats.dropped_overrun == 5
    assert drain(slow) == [str(number).encode() for number in range(1, 10)]
    assert pour(publisher, 3, start=200) == 3
    assert len(drain(slow)) == 3


def test_a_slow_subscriber_that_goes_lets_the_publisher_go_on(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small, session_expiry_interval=60), join("p", at=small)
    slow.subscribe("t")
    pour(publisher, 20)
    slow.lose()
    small.deadlines.run(small.clock.monotonic())
    assert len(publisher.take_only(Puback)) == 13


def test_what_a_publisher_sent_before_it_left_is_not_lost(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small, will=Will("t", b"will", 1))
    slow.subscribe("t")
    pour(publisher, 8)
    publisher.send(Disconnect())
    assert not publisher.link.closed
    payloads = drain(slow)
    assert payloads == [str(number).encode() for number in range(1, 9)]
    assert publisher.link.closed


def test_what_a_lost_publisher_had_sent_is_forwarded_without_waiting(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("t")
    pour(publisher, 8)
    publisher.lose()
    assert len(drain(slow)) == 8


def test_many_retained_messages_do_not_outrun_their_new_subscriber(small: Hub, join: Join) -> None:
    publisher, slow = join("p", at=small), join("s", at=small)
    for number in range(30):
        publisher.publish(f"t/{number}", b"x", 1, 1, retain=True)
    slow.subscribe("t/#")
    slow.publish("after", b"x", 1, 9)
    packets = slow.take()
    assert [type(packet) for packet in packets] == [Publish]
    received = []
    while packets:
        received += packets
        for packet in packets:
            if isinstance(packet, Publish):
                slow.send(Puback(packet.packet_id or 0))
        packets = slow.take()
    assert sum(isinstance(packet, Publish) for packet in received) == 30
    assert sum(isinstance(packet, Puback) for packet in received) == 1


def test_a_share_whose_only_member_is_slow_holds_its_publishers_too(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("$share/g/t")
    assert pour(publisher, 12) == 7
    assert len(drain(slow)) == 12


def test_an_overrun_client_gets_no_more_retained_messages_than_it_has_room_for(
    small: Hub, join: Join, later: Callable[[float], None]
) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    for number in range(20):
        publisher.publish(f"r/{number}", b"x", 1, 1, retain=True)
    slow.subscribe("t")
    publisher.take()
    pour(publisher, 12)
    later(10)
    slow.subscribe("r/#")
    assert small.stats.queued_messages == 8
    assert small.stats.dropped_overrun == 20 + 3


def test_a_packet_that_must_not_come_ends_the_connection_also_after_it_waited(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("t")
    pour(publisher, 8)
    publisher.send(Connack())
    assert not publisher.link.closed
    assert len(drain(slow)) == 8
    assert publisher.take_only(Disconnect)[0].reason is ReasonCode.PROTOCOL_ERROR


def test_a_bad_message_among_those_a_lost_publisher_left_ends_them(small: Hub, join: Join) -> None:
    slow, publisher = join("s", at=small), join("p", at=small)
    slow.subscribe("t")
    pour(publisher, 8)
    publisher.publish("", b"no such alias", properties=Properties(topic_alias=5))
    publisher.publish("t", b"behind", 1, 99)
    publisher.lose()
    assert len(drain(slow)) == 8
