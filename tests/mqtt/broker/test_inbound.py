"""What one client publishes: exactly once, by alias, within the quota."""

from __future__ import annotations

import pytest
from tests.mqtt.broker.conftest import Join, NewState

from homebot.mqtt import packets as mqtt


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
