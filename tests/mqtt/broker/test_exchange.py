"""Messages meet subscriptions: retained messages, options, overlaps, shares."""

from itertools import product

import pytest
from tests.mqtt.broker.conftest import Join, NewState

from homebot.mqtt import packets as mqtt

FOREVER = 0xFFFF_FFFF
QUOTA = mqtt.ReasonCode.QUOTA_EXCEEDED


def test_a_retained_message_is_not_kept_beyond_the_bounds(new_state: NewState, join: Join) -> None:
    state = new_state(max_retained_messages=2, max_retained_bytes=100)
    client = join(at=state)
    client.publish("a", b"1", 1, packet_id=1, retain=True)
    client.publish("b", b"2", 1, packet_id=2, retain=True)
    client.publish("c", b"3", 1, packet_id=3, retain=True)
    client.publish("b", bytes(99), 1, packet_id=4, retain=True)
    client.publish("b", bytes(98), 1, packet_id=5, retain=True)
    reasons = [ack.reason for ack in client.take_only(mqtt.Puback)]
    assert reasons == [mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS] * 2 + [QUOTA, QUOTA, QUOTA]
    client.publish("b", bytes(97), 1, packet_id=6, retain=True)
    assert client.take_only(mqtt.Puback)[0].reason is mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS
    assert (state.stats.retained_messages, state.stats.retained_bytes) == (2, 100)
    assert state.stats.retained_refused == 3


def test_an_expired_retained_message_is_not_sent_and_makes_room(new_state: NewState, join: Join) -> None:
    state = new_state(max_retained_messages=1)
    client = join(at=state)
    client.publish("a", retain=True, properties=mqtt.Properties(message_expiry_interval=5))
    state.clock.advance(5)  # type: ignore[attr-defined] # a ManualClock
    client.subscribe("#")
    assert client.messages() == []
    client.publish("b", retain=True)
    assert state.stats.retained_messages == 1
    assert state.stats.retained_refused == 0


def test_no_local_keeps_a_client_from_hearing_itself(join: Join) -> None:
    client, other = join("a"), join("b")
    client.subscribe(mqtt.MqttSubscription("t", 1, no_local=True))
    client.publish("t", b"own")
    other.publish("t", b"other")
    assert [message.payload for message in client.messages()] == [b"other"]
    client.subscribe("#", qos=0)
    client.publish("t", b"own", 1, packet_id=1)
    assert [(message.payload, message.qos) for message in client.messages()] == [(b"own", 0)]


def test_unsubscribing_says_what_was_not_there(join: Join) -> None:
    client = join()
    client.subscribe("a", "b/#")
    client.send(mqtt.Unsubscribe(7, ("a", "b/c", "b/#")))
    none = mqtt.ReasonCode.NO_SUBSCRIPTION_EXISTED
    assert client.take() == [mqtt.Unsuback(7, (mqtt.ReasonCode.SUCCESS, none, mqtt.ReasonCode.SUCCESS))]
    client.publish("a")
    client.publish("b/c")
    assert client.messages() == []
    assert client.state.stats.subscriptions == 0


def test_a_message_with_no_reader_is_acknowledged_as_such(join: Join) -> None:
    client, older = join("a"), join("b", version=mqtt.ProtocolVersion.V311)
    client.publish("t", qos=1, packet_id=1)
    older.publish("t", qos=1, packet_id=1)
    assert client.take() == [mqtt.Puback(1, mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS)]
    assert older.take() == [mqtt.Puback(1)]


@pytest.mark.parametrize("qos", [0, 1, 2])
def test_everything_a_publisher_adds_reaches_an_mqtt_5_client_and_nothing_of_it_an_older(join: Join, qos: int) -> None:
    properties = mqtt.Properties(
        payload_format_indicator=1,
        content_type="text",
        response_topic="r",
        correlation_data=b"7",
        user_properties=(("k", "v"), ("k", "w")),
    )
    client, older = join("a", to="t"), join("b", version=mqtt.ProtocolVersion.V311)
    older.subscribe("t")
    packet_id = 1 if qos else None
    client.publish("t", b"x", qos, packet_id, properties=properties)
    assert client.messages() == [mqtt.Publish("t", b"x", qos, packet_id=packet_id, properties=properties)]
    assert older.messages() == [mqtt.Publish("t", b"x", qos, packet_id=packet_id)]


def test_each_message_of_a_shared_subscription_goes_to_one_of_the_group(join: Join) -> None:
    members = [join(name) for name in "abc"]
    loner, other_group = join("l"), join("g")
    for member in members:
        member.subscribe("$share/group/t/#")
    loner.subscribe("t/1")
    other_group.subscribe("$share/other/t/1")
    for _ in range(6):
        loner.publish("t/1")
    assert [len(member.messages()) for member in members] == [2, 2, 2]
    assert len(loner.messages()) == len(other_group.messages()) == 6


def test_a_member_of_a_group_gets_the_retain_flag_as_it_asked_for_it(join: Join) -> None:
    plain, exact = join("plain", to="$share/plain/t"), join("exact")
    exact.subscribe(mqtt.MqttSubscription("$share/exact/t", 0, retain_as_published=True))
    for retain in (True, False):
        plain.publish("t", b"1", retain=retain)
    assert [message.retain for message in plain.messages()] == [False, False]
    assert [message.retain for message in exact.messages()] == [True, False]


def test_a_shared_subscription_prefers_those_who_are_there_and_not_slow(join: Join) -> None:
    absent = join("absent", session_expiry_interval=FOREVER)
    slow, quick = join("slow", receive_maximum=1), join("quick")
    for member in (absent, slow, quick):
        member.subscribe("$share/g/t")
    absent.lose()
    for number in range(6):
        quick.publish("t", qos=1, packet_id=number + 1)
    taken = slow.messages(), quick.messages()
    assert [len(messages) for messages in taken] == [1, 5]
    slow.acknowledge(*taken[0])
    quick.acknowledge(*taken[1])
    quick.lose()
    slow.lose()
    join("p").publish("t", qos=1, packet_id=1)
    assert len(join("absent", clean=False, present=True).messages()) == 1


def test_what_a_member_did_not_acknowledge_goes_to_another_when_its_session_ends(join: Join) -> None:
    first = join("first", receive_maximum=1, to="$share/g/t")
    publisher = join("p")
    publisher.publish("t", b"in flight", 1, packet_id=1)
    publisher.publish("t", b"queued", 1, packet_id=2)
    second = join("second", to="$share/g/t")
    first.lose()
    assert [message.payload for message in second.messages()] == [b"in flight", b"queued"]


def test_a_shared_subscription_gets_no_retained_messages(join: Join) -> None:
    client = join()
    client.publish("t", retain=True)
    client.subscribe("$share/g/t")
    assert client.messages() == []


def test_subscriptions_are_bounded(new_state: NewState, join: Join) -> None:
    state = new_state(max_subscriptions=2, max_topic_levels=3)
    client = join(at=state)
    granted, invalid = mqtt.ReasonCode.GRANTED_QOS_2, mqtt.ReasonCode.TOPIC_FILTER_INVALID
    assert client.subscribe("a", "a/b/c/d", "b", "c", "a") == (granted, invalid, granted, QUOTA, granted)


def test_properties_count_towards_the_bounds(new_state: NewState, join: Join) -> None:
    state = new_state(max_retained_bytes=1000)
    client = join(at=state)
    big = mqtt.Properties(user_properties=(("k" * 500, "v" * 500),))
    client.publish("t", b"x", 1, 1, retain=True, properties=big)
    assert client.take_only(mqtt.Puback)[0].reason is QUOTA


def test_subscribers_share_the_encoded_bytes(join: Join) -> None:
    subscribers = [join(name) for name in "abc"]
    for subscriber in subscribers:
        subscriber.subscribe("t", qos=0)
    join("p").publish("t", bytes(1000))
    first, second, third = (subscriber.link.last for subscriber in subscribers)
    assert first is second is third


@pytest.mark.parametrize("retain", [False, True])
@pytest.mark.parametrize("sent", [0, 1, 2])
def test_subscribers_of_one_message_get_it_each_with_their_own_options(join: Join, *, sent: int, retain: bool) -> None:
    options = list(product((None, 1, 2), (False, True), (0, 1, 2)))
    options += options[::-1]
    subscribers = [join(str(number)) for number in range(len(options))]
    for subscriber, (identifier, keeps_flag, qos) in zip(subscribers, options, strict=True):
        subscriber.subscribe(mqtt.MqttSubscription("t", qos, retain_as_published=keeps_flag), identifier=identifier)
    join("p").publish("t", b"x", sent, 1 if sent else None, retain=retain)
    for subscriber, (identifier, keeps_flag, granted) in zip(subscribers, options, strict=True):
        qos = min(granted, sent)
        properties = (
            mqtt.NO_PROPERTIES if identifier is None else mqtt.Properties(subscription_identifiers=(identifier,))
        )
        assert subscriber.messages() == [
            mqtt.Publish("t", b"x", qos, retain and keeps_flag, packet_id=1 if qos else None, properties=properties)
        ]
