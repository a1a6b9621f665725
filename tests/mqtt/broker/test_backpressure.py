"""Publishers wait for slow subscribers instead of losing messages."""

import pytest
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, PassTime

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import BrokerState

V311 = mqtt.ProtocolVersion.V311


@pytest.fixture
def state(new_state: NewState) -> BrokerState:
    """Eight messages may wait for a client: publishers are held back from the sixth on."""
    return new_state(max_inflight=1, max_queued_messages=8, max_held_packets=20)


def pour(client: MemoryClient, count: int, start: int = 1) -> int:
    """Publish *count* messages at QoS 1 and return how many were acknowledged."""
    for number in range(start, start + count):
        client.publish("t", str(number).encode(), 1, number)
    return len(client.take_only(mqtt.Puback))


def drain(client: MemoryClient) -> list[bytes]:
    """Acknowledge everything until nothing more comes."""
    payloads = []
    while messages := client.messages():
        payloads += [message.payload for message in messages]
        client.acknowledge(*messages)
    return payloads


def test_no_acknowledged_message_is_lost_however_slow_the_subscriber(state: BrokerState, join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p")
    assert pour(publisher, 15) == 7
    assert state.stats.queued_messages == 6
    assert drain(slow) == [str(number).encode() for number in range(1, 16)]
    assert len(publisher.take_only(mqtt.Puback)) == 8
    assert state.stats.holds >= 1
    assert state.stats.dropped_overrun == 0


def test_a_held_publisher_may_still_ping_and_acknowledge(join: Join) -> None:
    _, publisher = join("s", to="t"), join("p")
    publisher.subscribe("mine")
    pour(publisher, 9)
    join("o").publish("mine", b"1", 1, 1)
    (message,) = publisher.messages()
    publisher.send(mqtt.Puback(message.packet_id or 0), mqtt.Pingreq())
    assert publisher.take() == [mqtt.Pingresp()]


def test_a_client_that_floods_itself_does_not_block_itself(join: Join) -> None:
    client = join("both", to="t")
    acknowledged = 0
    for number in range(1, 31):
        client.publish("t", b"x", 1, number)
        for packet in client.take():
            acknowledged += isinstance(packet, mqtt.Puback)
            if isinstance(packet, mqtt.Publish):
                client.send(mqtt.Puback(packet.packet_id or 0))
    acknowledged += sum(isinstance(packet, mqtt.Puback) for packet in client.take())
    assert acknowledged == 30


def test_when_too_much_waits_the_socket_is_not_read(state: BrokerState, join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p", version=V311)
    pour(publisher, 7 + 19)
    assert publisher.link.reading
    publisher.publish("t", b"27", 1, 27)
    assert not publisher.link.reading
    drain(slow)
    assert publisher.link.reading
    assert state.stats.queued_messages == 0


def test_the_keep_alive_of_a_publisher_that_is_not_read_does_not_run_out(join: Join, pass_time: PassTime) -> None:
    slow, publisher = join("s", to="t"), join("p", keep_alive=4)
    pour(publisher, 40)
    pass_time(6)
    assert not publisher.link.closed
    drain(slow)
    pass_time(6)
    assert publisher.link.closed


def test_after_its_time_a_slow_subscriber_gets_only_what_it_has_room_for(
    state: BrokerState, join: Join, pass_time: PassTime
) -> None:
    slow, publisher = join("s", to="t"), join("p")
    pour(publisher, 12)
    pass_time(10)
    reasons = [ack.reason for ack in publisher.take_only(mqtt.Puback)]
    assert reasons == [mqtt.ReasonCode.SUCCESS] * 2 + [mqtt.ReasonCode.QUOTA_EXCEEDED] * 3
    assert state.stats.dropped_overrun == 3
    assert drain(slow) == [str(number).encode() for number in range(1, 10)]
    assert pour(publisher, 3, start=200) == 3
    assert len(drain(slow)) == 3


def test_a_slow_subscriber_that_goes_lets_the_publisher_go_on(state: BrokerState, join: Join) -> None:
    slow, publisher = join("s", session_expiry_interval=60, to="t"), join("p")
    pour(publisher, 20)
    slow.lose()
    state.deadlines.run(state.clock.monotonic())
    assert len(publisher.take_only(mqtt.Puback)) == 13


def test_what_a_publisher_sent_before_it_left_is_not_lost(join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p", will=mqtt.Will("t", b"will", 1))
    pour(publisher, 8)
    publisher.send(mqtt.Disconnect())
    assert not publisher.link.closed
    payloads = drain(slow)
    assert payloads == [str(number).encode() for number in range(1, 9)]
    assert publisher.link.closed


def test_what_a_lost_publisher_had_sent_is_forwarded_without_waiting(join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p")
    pour(publisher, 8)
    publisher.lose()
    assert len(drain(slow)) == 8


def test_many_retained_messages_take_no_room_of_their_new_subscriber(state: BrokerState, join: Join) -> None:
    publisher, slow = join("p"), join("s")
    for number in range(30):
        publisher.publish(f"t/{number}", b"x", 1, 1, retain=True)
    slow.subscribe("t/#")
    assert state.stats.queued_messages == 1
    publisher.publish("t/0", b"later", 1, 1)
    assert state.stats.queued_messages == 2
    assert drain(slow) == [b"x"] * 30 + [b"later"]
    assert state.stats.queued_messages == 0


def test_a_share_whose_only_member_is_slow_holds_its_publishers_too(join: Join) -> None:
    slow, publisher = join("s", to="$share/g/t"), join("p")
    assert pour(publisher, 12) == 7
    assert len(drain(slow)) == 12


def test_an_overrun_client_without_room_gets_no_retained_messages(
    state: BrokerState, join: Join, pass_time: PassTime
) -> None:
    slow, publisher = join("s"), join("p")
    for number in range(20):
        publisher.publish(f"r/{number}", b"x", 1, 1, retain=True)
    slow.subscribe("t")
    publisher.take()
    pour(publisher, 12)
    pass_time(10)
    slow.subscribe("r/#")
    assert state.stats.queued_messages == 8
    assert state.stats.dropped_overrun == 1 + 3


def test_a_packet_that_must_not_come_ends_the_connection_also_after_it_waited(join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p")
    pour(publisher, 8)
    publisher.send(mqtt.Connack())
    assert not publisher.link.closed
    assert len(drain(slow)) == 8
    assert publisher.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.PROTOCOL_ERROR


def test_a_bad_message_among_those_a_lost_publisher_left_ends_them(join: Join) -> None:
    slow, publisher = join("s", to="t"), join("p")
    pour(publisher, 8)
    publisher.publish("", b"no such alias", properties=mqtt.Properties(topic_alias=5))
    publisher.publish("t", b"behind", 1, 99)
    publisher.lose()
    assert len(drain(slow)) == 8


@pytest.fixture
def full(state: BrokerState, join: Join, pass_time: PassTime) -> tuple[MemoryClient, MemoryClient]:
    """A subscriber that took nothing for ten seconds, its queue full; and a publisher before MQTT 5, of 9 messages."""
    slow = join("s", session_expiry_interval=60, will=mqtt.Will("will", b"s"))
    publisher = join("o", version=V311)
    slow.subscribe("t")
    assert pour(publisher, 9) == 7
    pass_time(10)
    assert len(publisher.take_only(mqtt.Puback)) == 2
    assert state.stats.queued_messages == 8
    return slow, publisher


def test_what_cannot_be_refused_is_neither_acknowledged_nor_dropped(
    state: BrokerState, full: tuple[MemoryClient, MemoryClient]
) -> None:
    slow, publisher = full
    assert pour(publisher, 5, start=10) == 0
    assert state.stats.dropped_overrun == 0
    assert drain(slow) == [str(number).encode() for number in range(1, 15)]
    assert len(publisher.take_only(mqtt.Puback)) == 5


def test_at_qos_2_neither(full: tuple[MemoryClient, MemoryClient]) -> None:
    slow, publisher = full
    publisher.publish("t", b"10", 2, 10)
    assert publisher.take() == []
    assert drain(slow)[-1] == b"10"
    assert publisher.take_only(mqtt.Pubrec) == [mqtt.Pubrec(10)]


def test_other_publishers_are_not_held_by_a_full_queue_that_is_not_theirs(
    join: Join, full: tuple[MemoryClient, MemoryClient]
) -> None:
    other = join("p", version=V311)
    other.publish("elsewhere", b"x", 1, 1)
    other.publish("t", b"x", 0)
    other.publish("elsewhere", b"x", 1, 2)
    assert other.take_only(mqtt.Puback) == [mqtt.Puback(1), mqtt.Puback(2)]


def test_a_subscriber_that_stays_stuck_is_cut_off_and_keeps_its_session(
    state: BrokerState, join: Join, pass_time: PassTime, full: tuple[MemoryClient, MemoryClient]
) -> None:
    slow, publisher = full
    watcher = join("w", to="will")
    pour(publisher, 2, start=10)
    pass_time(10)
    assert slow.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.QUOTA_EXCEEDED
    assert state.stats.clients_stalled == 1
    assert [message.payload for message in watcher.messages()] == [b"s"]
    pass_time(0)
    assert len(publisher.take_only(mqtt.Puback)) == 2
    assert state.stats.dropped_offline == 2  # the bound of an absent client
    again = join("s", clean=False, present=True, session_expiry_interval=60)
    assert drain(again) == [b"1", *(str(number).encode() for number in range(4, 12))]


def test_a_subscriber_that_is_slow_but_alive_is_waited_for_and_not_cut_off(
    state: BrokerState, pass_time: PassTime, full: tuple[MemoryClient, MemoryClient]
) -> None:
    slow, publisher = full
    assert pour(publisher, 6, start=10) == 0
    received = []
    for _ in range(20):
        messages = slow.messages()
        received += [message.payload for message in messages]
        slow.acknowledge(*messages)  # one for each window of 10 s, which is one here
        pass_time(10)
    assert not slow.link.closed
    assert received == [str(number).encode() for number in range(1, 16)]
    assert len(publisher.take_only(mqtt.Puback)) == 6
    assert state.stats.dropped_overrun == state.stats.clients_stalled == 0


def test_a_publisher_that_reconnects_again_and_again_finds_no_more_room(
    state: BrokerState, join: Join, full: tuple[MemoryClient, MemoryClient]
) -> None:
    slow, publisher = full
    for _ in range(50):
        assert pour(publisher, 10, start=10) == 0
        publisher.lose()
        publisher = join("o", version=V311)
    assert state.stats.queued_messages == 8
    assert drain(slow) == [str(number).encode() for number in range(1, 10)]


def test_a_message_at_qos_2_without_room_is_taken_when_its_publisher_repeats_it(join: Join) -> None:
    slow, publisher = join("s"), join("o", version=V311, clean=False)
    slow.subscribe("t", qos=1)
    pour(publisher, 7)
    for number in range(8, 12):
        publisher.publish("t", str(number).encode(), 2, number)
    publisher.lose()
    again = join("o", version=V311, clean=False, present=True)
    drain(slow)
    again.publish("t", b"11", 2, 11, dup=True)
    assert drain(slow) == [b"11"]


def test_a_group_without_room_holds_its_publishers_and_one_with_room_does_not(join: Join, pass_time: PassTime) -> None:
    _, publisher = join("s", to="$share/g/t"), join("o", version=V311)
    pour(publisher, 9)
    pass_time(10)
    publisher.take()
    assert pour(publisher, 1, start=10) == 0
    quick, other = join("q", to="$share/g/t"), join("p", version=V311)
    assert pour(other, 1) == 1
    assert len(quick.messages()) == 1


def test_a_client_that_is_not_read_from_may_flood_itself_to_its_bound_alone(
    state: BrokerState, join: Join, pass_time: PassTime
) -> None:
    client = join("both", version=V311, to="t")
    for number in range(1, 31):
        client.publish("t", b"x", 1, number)
    pass_time(10)
    pass_time(10)
    assert client.link.closed
    assert state.stats.clients_stalled == 1
    assert state.stats.queued_messages <= 8


def test_a_client_that_comes_back_to_a_full_queue_holds_publishers_too(state: BrokerState, join: Join) -> None:
    slow, publisher = join("s", session_expiry_interval=60, to="t"), join("o", version=V311)
    slow.lose()
    assert pour(publisher, 10) == 10
    assert not state.exchange.crowded
    again = join("s", clean=False, present=True, session_expiry_interval=60)
    assert pour(publisher, 3, start=11) == 1  # one is in flight, so there is room for one
    assert drain(again) == [str(number).encode() for number in range(3, 14)]
    assert len(publisher.take_only(mqtt.Puback)) == 2
