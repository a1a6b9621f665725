"""Messages from and to one client: QoS, acknowledgement, redelivery, flow control, aliases, bounds."""

import pytest
from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState

from homebot.mqtt import packets as mqtt
from homebot.mqtt.packets import Properties, Publish

V31, V311, V5 = mqtt.ProtocolVersion.V31, mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5
FOREVER = 0xFFFF_FFFF


def payloads(client: MemoryClient) -> list[bytes]:
    return [message.payload for message in client.messages()]


def test_qos_2_takes_four_steps_and_then_is_over(join: Join) -> None:
    client = join(to="t")
    client.publish("t", qos=2, packet_id=3)
    assert client.take() == [mqtt.Publish("t", b"x", 2, packet_id=1), mqtt.Pubrec(3)]
    client.send(mqtt.Pubrel(3), mqtt.Pubrec(1))
    assert client.take() == [mqtt.Pubcomp(3), mqtt.Pubrel(1)]
    client.send(mqtt.Pubcomp(1), mqtt.Pubrel(3), mqtt.Pubrec(1))
    unknown = mqtt.ReasonCode.PACKET_IDENTIFIER_NOT_FOUND
    assert client.take() == [mqtt.Pubcomp(3, unknown), mqtt.Pubrel(1, unknown)]


def test_what_was_not_acknowledged_comes_again_in_order_when_the_client_returns(join: Join) -> None:
    client = join("s", session_expiry_interval=FOREVER, to="t")
    other = join("p")
    for number, qos in enumerate((1, 2, 2, 1)):
        other.publish("t", str(number).encode(), qos, packet_id=number + 1)
    client.send(mqtt.Pubrec(3))
    client.take()
    client.lose()
    other.publish("t", b"later", 1, packet_id=9)
    client = join("s", clean=False, present=True, session_expiry_interval=FOREVER)
    assert client.take() == [
        mqtt.Pubrel(3),
        mqtt.Publish("t", b"0", 1, dup=True, packet_id=1),
        mqtt.Publish("t", b"1", 2, dup=True, packet_id=2),
        mqtt.Publish("t", b"3", 1, dup=True, packet_id=4),
        mqtt.Publish("t", b"later", 1, packet_id=5),
    ]


def test_what_acknowledgements_make_room_for_is_sent_before_the_answer_to_a_later_packet(join: Join) -> None:
    """Acknowledgements that come together are one occasion to send, other packets between them part it."""
    client = join("s", receive_maximum=2, to="t")
    other = join("p")
    for number in range(5):
        other.publish("t", str(number).encode(), 1, packet_id=number + 1)
    client.take()
    client.send(mqtt.Puback(1), mqtt.Puback(2), mqtt.Pingreq(), mqtt.Puback(3))
    assert client.take() == [
        mqtt.Publish("t", b"2", 1, packet_id=3),
        mqtt.Publish("t", b"3", 1, packet_id=4),
        mqtt.Pingresp(),
        mqtt.Publish("t", b"4", 1, packet_id=5),
    ]


def test_a_receive_maximum_lowered_on_return_is_kept(join: Join) -> None:
    client = join("s", session_expiry_interval=FOREVER, to="t")
    other = join("p")
    for number in range(3):
        other.publish("t", str(number).encode(), 1, packet_id=number + 1)
    client.lose()
    client = join("s", clean=False, present=True, receive_maximum=1)
    for expected in (b"0", b"1", b"2"):
        (message,) = client.messages()
        assert (message.payload, message.dup) == (expected, True)
        client.acknowledge(message)


def test_a_qos_2_message_counts_until_pubcomp(join: Join) -> None:
    client = join("s", receive_maximum=1, to="t")
    client.publish("t", b"one", 2, packet_id=1)
    client.publish("t", b"two", 2, packet_id=2)
    assert payloads(client) == [b"one"]
    client.send(mqtt.Pubrec(1))
    assert payloads(client) == []
    client.send(mqtt.Pubcomp(1))
    assert payloads(client) == [b"two"]


def test_a_message_the_client_refuses_is_over(join: Join) -> None:
    client = join("s", receive_maximum=1, to="t")
    client.publish("t", b"one", 2, packet_id=1)
    client.publish("t", b"two", 2, packet_id=2)
    client.send(mqtt.Pubrec(1, mqtt.ReasonCode.QUOTA_EXCEEDED))
    assert payloads(client) == [b"one", b"two"]


def test_an_acknowledgement_of_the_wrong_kind_ends_the_connection(join: Join) -> None:
    for answer, qos in ((mqtt.Puback(1), 2), (mqtt.Pubrec(1), 1)):
        client = join("s", to="t")
        client.publish("t", qos=qos, packet_id=5)
        client.send(answer)
        (goodbye,) = client.take_only(mqtt.Disconnect)
        assert goodbye.reason is mqtt.ReasonCode.PROTOCOL_ERROR


def test_an_acknowledgement_nobody_waits_for_is_ignored(join: Join) -> None:
    client = join()
    client.send(mqtt.Puback(77), mqtt.Pubcomp(78))
    assert client.take() == []
    assert not client.link.closed


def test_the_queue_of_an_absent_client_drops_its_oldest_and_counts(new_state: NewState, join: Join) -> None:
    state = new_state(max_queued_messages=3)
    client = join("s", at=state, session_expiry_interval=FOREVER, to="t")
    client.lose()
    other = join("p", at=state)
    for number in range(5):
        other.publish("t", str(number).encode(), 1, packet_id=number + 1)
    other.publish("t", b"qos 0", 0)
    assert [each.reason for each in other.take_only(mqtt.Puback)] == [mqtt.ReasonCode.SUCCESS] * 5
    assert state.stats.queued_messages == 3
    client = join("s", at=state, clean=False, present=True)
    assert payloads(client) == [b"2", b"3", b"4"]
    assert state.stats.dropped_offline == 2


def test_the_queue_of_an_absent_client_is_bounded_in_bytes(new_state: NewState, join: Join) -> None:
    state = new_state(max_queued_bytes=1000)
    client = join("s", at=state, session_expiry_interval=FOREVER, to="t")
    client.lose()
    other = join("p", at=state)
    for number in range(4):
        other.publish("t", str(number).encode() * 600, 1, packet_id=number + 1)
    client = join("s", at=state, clean=False, present=True)
    assert payloads(client) == [b"2" * 600, b"3" * 600]


def test_qos_0_for_a_full_socket_is_dropped_and_counted_and_qos_1_waits(join: Join) -> None:
    client, other = join("s", to="t"), join("p")
    client.link.write_blocked = True
    other.publish("t", b"lost", 0)
    other.publish("t", b"kept", 1, packet_id=1)
    assert client.messages() == []
    client.link.write_blocked = False
    client.peer.writable()
    assert payloads(client) == [b"kept"]
    assert client.state.stats.dropped_qos0 == 1


def test_retained_messages_wait_for_a_full_socket_even_at_qos_0(join: Join) -> None:
    client, other = join("s"), join("p")
    for number in range(3):
        other.publish(f"t/{number}", b"old", 0, retain=True)
    client.link.write_blocked = True
    client.subscribe("t/#")
    other.publish("t/0", b"new", 0)
    client.link.write_blocked = False
    client.peer.writable()
    assert payloads(client) == [b"old", b"old", b"old", b"new"]


def test_packet_ids_start_anew_after_the_last_and_pass_over_those_in_use(join: Join) -> None:
    client = join("s", to="t")
    client.publish("t", b"open", 1, packet_id=1)
    client.state.sessions._sessions["s"].in_flight._last_id = 65_534
    client.publish("t", b"last", 1, packet_id=1)
    client.publish("t", b"next", 1, packet_id=1)
    assert [message.packet_id for message in client.messages()] == [1, 65_535, 2]


def test_qos_0_messages_that_waited_are_dropped_when_the_client_goes(join: Join) -> None:
    client, other = join("s", session_expiry_interval=FOREVER), join("p")
    other.publish("t/0", b"0", 0, retain=True)
    other.publish("t/1", b"1", 1, 1, retain=True)
    client.link.write_blocked = True
    client.subscribe("t/#")
    client.lose()
    assert payloads(join("s", clean=False, present=True)) == [b"1"]


def test_a_message_that_became_too_large_is_not_sent_again(join: Join) -> None:
    client = join("s", session_expiry_interval=FOREVER, to="t")
    client.publish("t", bytes(100), 1, 1)
    client.publish("t", b"small", 1, 2)
    client.lose()
    client = join("s", clean=False, present=True, maximum_packet_size=50)
    assert payloads(client) == [b"small"]


def test_an_acknowledgement_before_the_second_sending_stops_it(join: Join) -> None:
    client = join("s", session_expiry_interval=FOREVER, to="t")
    for number in (1, 2):
        client.publish("t", str(number).encode(), 1, number)
    client.lose()
    client = join("s", clean=False, present=True, receive_maximum=1)
    client.send(mqtt.Puback(2), mqtt.Puback(1))
    assert payloads(client) == [b"1"]


def alias(number: int) -> mqtt.Properties:
    return mqtt.Properties(topic_alias=number)


def test_a_qos_2_message_is_forwarded_once_even_over_a_lost_connection(join: Join) -> None:
    watcher = join("w", to="t")
    client = join(session_expiry_interval=60)
    client.publish("t", qos=2, packet_id=5)
    client.lose()
    client = join(clean=False, present=True, session_expiry_interval=60)
    client.publish("t", qos=2, packet_id=5, dup=True)
    client.send(mqtt.Pubrel(5))
    assert client.take() == [mqtt.Pubrec(5), mqtt.Pubcomp(5)]
    assert len(watcher.messages()) == 1


@pytest.mark.parametrize(
    ("number", "reason"), [(65, mqtt.ReasonCode.TOPIC_ALIAS_INVALID), (64, mqtt.ReasonCode.PROTOCOL_ERROR)]
)
def test_an_alias_too_high_or_not_set_ends_the_connection(join: Join, number: int, reason: mqtt.ReasonCode) -> None:
    client = join()
    client.publish("", properties=alias(number))
    assert client.take_only(mqtt.Disconnect)[0].reason is reason


def test_more_messages_than_receive_maximum_end_the_connection(new_state: NewState, join: Join) -> None:
    client = join(at=new_state(receive_maximum=3))
    for packet_id in (1, 2, 3):
        client.publish("t", qos=2, packet_id=packet_id)
    client.publish("t", qos=2, packet_id=3, dup=True)
    client.publish("t", qos=0)
    assert not client.link.closed
    client.send(mqtt.Pubrel(1))
    client.publish("t", qos=2, packet_id=4)
    assert not client.link.closed
    client.publish("t", qos=1, packet_id=5)
    assert client.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.RECEIVE_MAXIMUM_EXCEEDED


def test_an_older_client_knows_no_receive_maximum(new_state: NewState, join: Join) -> None:
    client = join(at=new_state(receive_maximum=1), version=mqtt.ProtocolVersion.V311)
    for packet_id in range(1, 50):
        client.publish("t", qos=2, packet_id=packet_id)
    assert not client.link.closed


def test_a_client_that_wants_aliases_gets_them(join: Join) -> None:
    client = join(topic_alias_maximum=1)
    client.subscribe("#", qos=1)
    for payload in (b"1", b"2"):
        client.publish("a", payload, 1, 1)
        client.publish("b", payload)
    one = Properties(topic_alias=1)
    assert client.messages() == [
        Publish("a", b"1", 1, packet_id=1, properties=one),
        Publish("b", b"1"),
        Publish("", b"2", 1, packet_id=2, properties=one),
        Publish("b", b"2"),
    ]


def test_a_message_sent_again_on_a_new_connection_has_its_topic(join: Join) -> None:
    client = join(topic_alias_maximum=5, session_expiry_interval=60)
    client.subscribe("#", qos=1)
    client.publish("a", b"0", 0)
    client.publish("a", b"1", 1, 1)
    client.lose()
    client = join(clean=False, present=True)
    assert client.messages() == [Publish("a", b"1", 1, dup=True, packet_id=1)]


def test_a_message_too_large_for_the_client_is_left_out_counted_and_told(join: Join) -> None:
    client, other = join(maximum_packet_size=64, topic_alias_maximum=1, receive_maximum=1, to="t"), join("b")
    with capture_logs() as lines:
        for size in (64, 57, 30):
            other.publish("t", bytes(size), 1, 1)
    (message,) = client.messages()
    assert (message.topic, len(message.payload)) == ("t", 30)
    assert client.state.stats.dropped_too_large == 2
    assert [line["message"] for line in lines] == [
        f"client 'a' (memory) missed a message on 't': it has {size} bytes, the client accepts at most 64"
        for size in (75, 68)
    ]


def test_the_largest_message_that_fits_is_sent(join: Join) -> None:
    client = join(maximum_packet_size=64, to="t")
    client.publish("t", bytes(58))
    client.publish("t", bytes(59))
    assert [len(message.payload) for message in client.messages()] == [58]
