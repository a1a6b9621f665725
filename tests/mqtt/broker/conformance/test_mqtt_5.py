"""The ground of the Paho suite's 27 tests of MQTT 5."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from homebot.mqtt.broker import Broker
from homebot.mqtt.packets import (
    Connect,
    Disconnect,
    FilterRequest,
    Properties,
    ProtocolVersion,
    Puback,
    Publish,
    Pubrec,
    ReasonCode,
    Will,
)

if TYPE_CHECKING:
    from tests.mqtt.broker.conformance.conftest import Meet
    from tests.mqtt.broker.conftest import Dial, Stranger

    PassTime = Callable[[float], None]

PAIRS = (("a", "2"), ("c", "3"))


def test_basic_a_second_connect_and_a_wrong_protocol_name_end_the_connection(meet: Meet, stranger: Stranger) -> None:
    client = meet()
    client.send(Connect("a", ProtocolVersion.V5))
    assert [goodbye.reason for goodbye in client.ended_with()] == [ReasonCode.PROTOCOL_ERROR]
    impostor = stranger()
    impostor.send_bytes(b"\x10\x0e\x00\x02hj\x05\x02\x00\x00\x00\x00\x03abc")
    assert impostor.link.closed


def test_retained_messages_come_at_their_qos_with_their_user_properties(meet: Meet) -> None:
    client = meet()
    for qos, topic in enumerate(("hall/0", "stairs/1", "hall/2")):
        client.publish(topic, b"kept", qos, retain=True, user_properties=PAIRS)
    client.subscribe("+/+")
    assert [message.qos for message in client.messages] == [0, 1, 2]
    assert {message.properties.user_properties for message in client.messages} == {PAIRS}


def test_will_message_comes_with_its_properties_when_the_keep_alive_runs_out(meet: Meet, pass_time: PassTime) -> None:
    will = Will("hall", b"gone", 2, False, Properties(will_delay_interval=0, user_properties=PAIRS))
    silent, watcher = meet("a", keep_alive=2, will=will), meet("b", clean=False)
    watcher.subscribe("hall")
    pass_time(3.1)
    watcher.settle()
    silent.settle()
    assert [goodbye.reason for goodbye in silent.ended_with()] == [ReasonCode.KEEP_ALIVE_TIMEOUT]
    assert watcher.payloads == [b"gone"]
    assert watcher.messages[0].properties.user_properties == PAIRS


@pytest.mark.parametrize("clean", [True, False])
def test_zero_length_client_id_is_let_in(meet: Meet, *, clean: bool) -> None:
    assert meet("", clean=clean).connack.reason is ReasonCode.SUCCESS


def test_assigned_client_id_is_told(meet: Meet) -> None:
    names = {meet("").connack.properties.assigned_client_identifier for _ in range(2)}
    assert len(names) == 2
    assert None not in names
    assert "" not in names


def test_session_expiry_counts_from_the_disconnect_which_may_change_it(meet: Meet, pass_time: PassTime) -> None:
    def present_after(left: float, **properties: object) -> bool:
        pass_time(left)
        client = meet("a", clean=False, **properties)
        found = client.connack.session_present
        client.leave()
        return found

    meet("a", session_expiry_interval=0).leave()
    assert not present_after(0, session_expiry_interval=0)
    meet("a", session_expiry_interval=5).leave()
    assert present_after(2, session_expiry_interval=5)
    assert not present_after(6, session_expiry_interval=5)

    meet("a", session_expiry_interval=1).leave(session_expiry_interval=5)
    pass_time(3)
    client = meet("a", clean=False, session_expiry_interval=1)
    assert client.connack.session_present
    client.leave(session_expiry_interval=0)
    assert not present_after(0)


def test_user_properties_arrive_in_their_order_at_every_qos(meet: Meet) -> None:
    client = meet()
    client.subscribe("hall")
    client.publish_each_qos("hall", user_properties=PAIRS)
    assert [(each.qos, each.properties.user_properties) for each in client.messages] == [
        (qos, PAIRS) for qos in range(3)
    ]


def test_payload_format_and_content_type_arrive_at_every_qos(meet: Meet) -> None:
    client = meet()
    client.subscribe("hall")
    client.publish_each_qos("hall", payload_format_indicator=1, content_type="name")
    assert len(client.messages) == 3
    for message in client.messages:
        assert message.properties == Properties(payload_format_indicator=1, content_type="name")


def test_publication_expiry_counts_down_while_a_message_waits(meet: Meet, pass_time: PassTime) -> None:
    client, other = meet("b", session_expiry_interval=99_999), meet("a")
    client.subscribe("hall")
    client.leave(session_expiry_interval=999_999_999)
    for seconds in (1, 6):
        for qos in (1, 2):
            other.publish("hall", b"%d" % seconds, qos, message_expiry_interval=seconds)
    pass_time(3)
    client = meet("b", clean=False)
    assert client.payloads == [b"6", b"6"]
    assert [each.properties.message_expiry_interval for each in client.messages] == [3, 3]


def test_subscribe_options_no_local(meet: Meet) -> None:
    one, two = meet("a"), meet("b")
    for client in (one, two):
        client.subscribe(FilterRequest("hall", 2, no_local=True))
    one.publish("hall", b"from a", 1)
    one.settle(two)
    assert (one.payloads, two.payloads) == ([], [b"from a"])


def test_subscribe_options_retain_as_published(meet: Meet) -> None:
    client = meet()
    client.subscribe(FilterRequest("hall", 2, retain_as_published=True))
    client.publish("hall", b"plain", 1)
    client.publish("hall", b"kept", 1, retain=True)
    assert [(each.payload, each.retain) for each in client.messages] == [(b"plain", False), (b"kept", True)]


@pytest.mark.parametrize(("handling", "first", "second"), [(0, 3, 3), (1, 3, 0), (2, 0, 0)])
def test_subscribe_options_retain_handling(meet: Meet, handling: int, first: int, second: int) -> None:
    for qos in range(3):
        meet("b").publish(f"hall/{qos}", b"kept", qos, retain=True)
    client = meet()
    counts = []
    for _ in range(2):
        client.messages.clear()
        client.subscribe(FilterRequest("hall/+", 2, retain_handling=handling))
        counts.append(len(client.messages))
    assert counts == [first, second]


def test_subscribe_identifiers_come_in_one_copy_with_those_of_all_that_match(meet: Meet) -> None:
    one, two = meet("a"), meet("b")
    one.subscribe("hall", identifier=456_789)
    two.subscribe("hall", identifier=2)
    two.subscribe("hall/#", identifier=3)
    two.publish("hall", b"x", 1)
    one.settle(two)
    (for_one,), (for_two,) = one.messages, two.messages
    assert for_one.properties.subscription_identifiers == (456_789,)
    assert set(for_two.properties.subscription_identifiers) == {2, 3}


def test_request_response_works_over_one_topic(meet: Meet) -> None:
    asker, answerer = meet("a"), meet("b")
    for client in (asker, answerer):
        client.subscribe(FilterRequest("hall", 2, no_local=True))
    asker.publish("hall", b"question", 1, response_topic="hall", correlation_data=b"334")
    answerer.settle()
    (question,) = answerer.messages
    assert question.properties == Properties(response_topic="hall", correlation_data=b"334")
    answerer.publish(question.properties.response_topic or "", b"answer", 1, correlation_data=b"334")
    asker.settle()
    assert [(each.payload, each.properties.correlation_data) for each in asker.messages] == [(b"answer", b"334")]


def test_client_topic_alias_zero_is_invalid(meet: Meet) -> None:
    client = meet()
    client.client.send_bytes(b"\x32\x0b\x00\x01t\x00\x01\x03\x23\x00\x00xy")
    client.settle()
    assert [goodbye.reason for goodbye in client.ended_with()] == [ReasonCode.TOPIC_ALIAS_INVALID]


def test_client_topic_alias_stands_for_its_topic_until_the_connection_ends(meet: Meet) -> None:
    client = meet(topic_alias_maximum=0, session_expiry_interval=99_999)
    assert client.connack.properties.topic_alias_maximum
    client.subscribe("hall")
    client.publish("hall", b"1", 1, topic_alias=1)
    client.publish("", b"2", 1, topic_alias=1)
    assert [(each.topic, each.payload) for each in client.messages] == [("hall", b"1"), ("hall", b"2")]
    client.leave()
    client = meet(clean=False)
    client.publish("hall", b"3", 1)
    assert client.payloads == [b"3"]
    client.publish("", b"4", 1, topic_alias=1)
    assert [goodbye.reason for goodbye in client.ended_with()] == [ReasonCode.PROTOCOL_ERROR]


def test_server_topic_alias_is_used_where_the_client_takes_one(meet: Meet) -> None:
    client = meet(topic_alias_maximum=1)
    client.subscribe("hall")
    client.publish_each_qos("hall")
    assert [(each.topic, each.properties.topic_alias) for each in client.messages] == [("hall", 1), ("", 1), ("", 1)]


@pytest.mark.parametrize("properties", [{}, {"topic_alias_maximum": 0}])
def test_server_topic_alias_is_not_used_where_the_client_takes_none(meet: Meet, properties: dict[str, int]) -> None:
    client = meet(**properties)
    client.subscribe("hall")
    client.publish_each_qos("hall")
    assert [(each.topic, each.properties.topic_alias) for each in client.messages] == [("hall", None)] * 3


def test_maximum_packet_size_keeps_larger_messages_from_a_client(meet: Meet) -> None:
    client = meet(maximum_packet_size=64)
    assert (client.connack.properties.maximum_packet_size or 2**28) >= 65_535
    client.subscribe("hall")
    client.publish("hall", b"." * 32)
    client.publish("hall", b"." * 64, 1)
    assert client.payloads == [b"." * 32]


def test_server_keep_alive_is_told_to_those_who_asked_for_more(meet: Meet) -> None:
    assert meet(keep_alive=120).connack.properties.server_keep_alive == 60
    assert meet(keep_alive=59).connack.properties.server_keep_alive is None


def test_flow_control_1_no_more_than_receive_maximum_is_in_flight(meet: Meet) -> None:
    client = meet(receive_maximum=2)
    client.subscribe("hall", qos=2)
    client.deaf = True
    for number in range(3):
        client.publish("hall", b"%d" % number, 1)
    packets = client.client.take()
    first, second = (packet for packet in packets if isinstance(packet, Publish))
    assert len([packet for packet in packets if isinstance(packet, Puback)]) == 3
    client.client.acknowledge(first)
    assert [message.payload for message in client.client.messages()] == [b"2"]
    assert (first.payload, second.payload) == (b"0", b"1")


async def test_flow_control_2_the_reason_reaches_a_client_that_only_sends(dial: Dial) -> None:
    """It reads nothing until it has sent one message more than the broker's Receive Maximum."""
    async with Broker() as broker:
        client = await dial(broker)
        maximum = 1024
        await client.send(*(Publish("hall", b"x", 2, packet_id=number + 1) for number in range(maximum + 1)))
        *answers, goodbye = await client.rest()
        assert answers == [Pubrec(number + 1, ReasonCode.NO_MATCHING_SUBSCRIBERS) for number in range(maximum)]
        assert isinstance(goodbye, Disconnect)
        assert goodbye.reason is ReasonCode.RECEIVE_MAXIMUM_EXCEEDED


@pytest.mark.parametrize(("delay", "expiry", "seconds"), [(3, 5, 3), (5, 0, 0), (5, 2, 2)])
def test_will_delay_is_cut_short_by_the_end_of_the_session(
    meet: Meet, pass_time: PassTime, delay: int, expiry: int, seconds: int
) -> None:
    will = Will("hall", b"gone", 2, False, Properties(will_delay_interval=delay))
    client, watcher = meet("a", will=will, session_expiry_interval=expiry), meet("b")
    watcher.subscribe("hall")
    client.client.lose()
    if seconds:
        pass_time(seconds - 0.1)
        watcher.settle()
        assert watcher.payloads == []
    pass_time(0.2)
    watcher.settle()
    assert watcher.payloads == [b"gone"]


def test_shared_subscriptions_give_each_message_to_one_member(meet: Meet) -> None:
    one, two = meet("a"), meet("b")
    for client in (one, two):
        client.subscribe("$share/home/hall", "stairs")
    two.publish("stairs", b"all")
    one.settle(two)
    assert (one.payloads, two.payloads) == ([b"all"], [b"all"])
    two.publish("hall", b"one")
    one.settle(two)
    assert sorted(one.payloads + two.payloads) == [b"all", b"all", b"one"]
