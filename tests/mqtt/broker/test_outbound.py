"""What is written to one client: its size limit, its topic aliases."""

from __future__ import annotations

from structlog.testing import capture_logs
from tests.mqtt.broker.conftest import Join

from homebot.mqtt.packets import Properties, Publish


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
