"""The Paho suite's tests of MQTT 3.1.1, for MQTT 3.1 as well, and for MQTT 5 if it behaves alike."""

from functools import partial

import pytest
from tests.mqtt.broker.conformance.conftest import Meet, Talker
from tests.mqtt.broker.conftest import Stranger

from homebot.mqtt.packets import NO_PROPERTIES, Connect, Properties, ProtocolVersion, ReasonCode

V31, V311, V5 = ProtocolVersion.V31, ProtocolVersion.V311, ProtocolVersion.V5


@pytest.fixture(params=[V31, V311], ids=["3.1", "3.1.1"])
def meet(request: pytest.FixtureRequest, meet: Meet) -> Meet:
    """Of a version before 5."""
    return partial(meet, version=request.param)


@pytest.fixture(params=[V31, V311, V5], ids=["3.1", "3.1.1", "5"])
def any_version(request: pytest.FixtureRequest) -> ProtocolVersion:
    return request.param  # type: ignore[no-any-return] # a parameter


@pytest.fixture
def meet_any(stranger: Stranger, any_version: ProtocolVersion) -> Meet:
    """Of any version; a session that is not clean lasts."""

    def make(client_id: str = "a", *, clean: bool = True) -> Talker:
        lasting = 0 if clean or any_version is not V5 else 99_999
        properties = Properties(session_expiry_interval=lasting) if lasting else NO_PROPERTIES
        talker = Talker(stranger(any_version))
        talker.send(Connect(client_id, any_version, clean, properties=properties))
        return talker

    return make


def test_basic_a_client_hears_itself_at_every_qos(meet_any: Meet) -> None:
    meet_any().leave()
    client = meet_any()
    assert not client.connack.session_present
    client.subscribe("hall")
    client.publish_each_qos("hall")
    client.settle()
    assert [(message.qos, message.payload) for message in client.messages] == [(0, b"0"), (1, b"1"), (2, b"2")]


def test_retained_messages_come_at_their_qos_until_they_are_cleared(meet: Meet) -> None:
    client = meet()
    topics = ("hall/0", "stairs/1", "hall/2")
    for qos, topic in enumerate(topics):
        client.publish(topic, b"kept", qos, retain=True)
    client.subscribe("+/+")
    assert [(each.topic, each.qos, each.retain) for each in client.messages] == [
        ("hall/0", 0, True),
        ("stairs/1", 1, True),
        ("hall/2", 2, True),
    ]
    client.leave()
    client = meet()
    for qos, topic in enumerate(topics):
        client.publish(topic, b"", qos, retain=True)
    client.subscribe("+/+")
    assert client.messages == []


def test_zero_length_client_id_needs_a_clean_session(meet: Meet) -> None:
    client = meet("", version=V311, clean=False)
    assert client.connack.reason is ReasonCode.CLIENT_IDENTIFIER_NOT_VALID
    assert client.client.link.closed
    assert meet("", version=V311).connack.reason is ReasonCode.SUCCESS


def test_offline_message_queueing_keeps_qos_1_and_2(meet_any: Meet) -> None:
    client = meet_any("a", clean=False)
    client.subscribe("+/+")
    client.leave()
    meet_any("b").publish_each_qos("hall/lamp")
    client = meet_any("a", clean=False)
    assert [message.qos for message in client.messages] == [1, 2]


def test_overlapping_subscriptions_give_one_copy_at_the_highest_qos(meet_any: Meet) -> None:
    client = meet_any()
    client.subscribe("hall/#", qos=2)
    client.subscribe("hall/+", qos=1)
    client.publish("hall/lamp", b"on", 2)
    assert [message.qos for message in client.messages] == [2]


def test_redelivery_on_reconnect_repeats_what_was_not_acknowledged(meet_any: Meet) -> None:
    client = meet_any("b", clean=False)
    client.subscribe("hall/#")
    client.deaf = True
    client.publish("hall/1", b"1", 1)
    client.publish("hall/2", b"2", 2)
    client.leave()
    client = meet_any("b", clean=False)
    assert [(each.payload, each.qos, each.dup) for each in client.messages] == [(b"1", 1, True), (b"2", 2, True)]


def test_subscribe_failure_is_0x80(meet_any: Meet) -> None:
    assert meet_any().subscribe("test/nosubscribe").reasons == (0x80,)
