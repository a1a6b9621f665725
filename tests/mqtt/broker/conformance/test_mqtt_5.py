"""What the Paho suite's 27 tests of MQTT 5 ask for beyond the tests of sessions, exchange and packets."""

import pytest
from tests.mqtt.broker.conformance.conftest import Meet
from tests.mqtt.broker.conftest import Dial, PassTime

from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import Broker

PAIRS = (("a", "2"), ("c", "3"))


def test_retained_messages_come_at_their_qos_with_their_user_properties(meet: Meet) -> None:
    client = meet()
    for qos, topic in enumerate(("hall/0", "stairs/1", "hall/2")):
        client.publish(topic, b"kept", qos, retain=True, user_properties=PAIRS)
    client.subscribe("+/+")
    assert [message.qos for message in client.messages] == [0, 1, 2]
    assert {message.properties.user_properties for message in client.messages} == {PAIRS}


def test_will_message_comes_with_its_properties_when_the_keep_alive_runs_out(meet: Meet, pass_time: PassTime) -> None:
    will = mqtt.Will("hall", b"gone", 2, False, mqtt.Properties(will_delay_interval=0, user_properties=PAIRS))
    silent, watcher = meet("a", keep_alive=2, will=will), meet("b", clean=False)
    watcher.subscribe("hall")
    pass_time(3.1)
    watcher.settle()
    silent.settle()
    assert [goodbye.reason for goodbye in silent.ended_with()] == [mqtt.ReasonCode.KEEP_ALIVE_TIMEOUT]
    assert watcher.payloads == [b"gone"]
    assert watcher.messages[0].properties.user_properties == PAIRS


@pytest.mark.parametrize("clean", [True, False])
def test_zero_length_client_id_is_let_in(meet: Meet, *, clean: bool) -> None:
    assert meet("", clean=clean).connack.reason is mqtt.ReasonCode.SUCCESS


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


@pytest.mark.parametrize(("handling", "first", "second"), [(0, 3, 3), (1, 3, 0), (2, 0, 0)])
def test_subscribe_options_retain_handling(meet: Meet, handling: int, first: int, second: int) -> None:
    for qos in range(3):
        meet("b").publish(f"hall/{qos}", b"kept", qos, retain=True)
    client = meet()
    counts = []
    for _ in range(2):
        client.messages.clear()
        client.subscribe(mqtt.MqttSubscription("hall/+", 2, retain_handling=handling))
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
    assert [goodbye.reason for goodbye in client.ended_with()] == [mqtt.ReasonCode.PROTOCOL_ERROR]


@pytest.mark.parametrize("properties", [{}, {"topic_alias_maximum": 0}])
def test_server_topic_alias_is_not_used_where_the_client_takes_none(meet: Meet, properties: dict[str, int]) -> None:
    client = meet(**properties)
    client.subscribe("hall")
    client.publish_each_qos("hall")
    assert [(each.topic, each.properties.topic_alias) for each in client.messages] == [("hall", None)] * 3


def test_server_keep_alive_is_told_to_those_who_asked_for_more(meet: Meet) -> None:
    assert meet(keep_alive=120).connack.properties.server_keep_alive == 60
    assert meet(keep_alive=59).connack.properties.server_keep_alive is None


async def test_flow_control_2_the_reason_reaches_a_client_that_only_sends(dial: Dial) -> None:
    """It reads nothing until it has sent one message more than the broker's Receive Maximum."""
    async with Broker() as broker:
        client = await dial(broker)
        maximum = 1024
        await client.send(*(mqtt.Publish("hall", b"x", 2, packet_id=number + 1) for number in range(maximum + 1)))
        *answers, goodbye = await client.rest()
        assert answers == [
            mqtt.Pubrec(number + 1, mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS) for number in range(maximum)
        ]
        assert isinstance(goodbye, mqtt.Disconnect)
        assert goodbye.reason is mqtt.ReasonCode.RECEIVE_MAXIMUM_EXCEEDED


@pytest.mark.parametrize(("delay", "expiry", "seconds"), [(3, 5, 3), (5, 0, 0), (5, 2, 2)])
def test_will_delay_is_cut_short_by_the_end_of_the_session(
    meet: Meet, pass_time: PassTime, delay: int, expiry: int, seconds: int
) -> None:
    will = mqtt.Will("hall", b"gone", 2, False, mqtt.Properties(will_delay_interval=delay))
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
