"""One connection from CONNECT to its end."""

import pytest
from tests.mqtt.broker.conftest import Join, NewState, PassTime, Stranger

from homebot.mqtt import packets as mqtt

V31, V311, V5 = mqtt.ProtocolVersion.V31, mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5


class Gatekeeper:
    """A policy that knows one forbidden word."""

    def subscribe(self, client_id: str, filter: str) -> mqtt.ReasonCode:  # noqa: A002, ARG002 - fills the port
        return mqtt.ReasonCode.NOT_AUTHORIZED if "secret" in filter else mqtt.ReasonCode.SUCCESS

    def publish(self, client_id: str, topic: str) -> mqtt.ReasonCode:  # noqa: ARG002 - fills the port
        return mqtt.ReasonCode.NOT_AUTHORIZED if "secret" in topic else mqtt.ReasonCode.SUCCESS


def test_the_client_is_told_what_the_broker_can_do(new_state: NewState, stranger: Stranger) -> None:
    client = stranger(at=new_state(receive_maximum=30, max_packet_size=5000, topic_alias_maximum=7))
    client.send(mqtt.Connect("a"))
    (connack,) = client.take()
    assert connack == mqtt.Connack(
        properties=mqtt.Properties(receive_maximum=30, maximum_packet_size=5000, topic_alias_maximum=7)
    )


def test_an_older_client_is_told_nothing_it_does_not_know(stranger: Stranger) -> None:
    client = stranger(V31)
    client.send(mqtt.Connect("a", V31))
    assert client.take() == [mqtt.Connack()]


@pytest.mark.parametrize("version", [V31, V311, V5])
def test_the_password_is_checked(new_state: NewState, stranger: Stranger, version: mqtt.ProtocolVersion) -> None:
    state = new_state(credentials={"ann": "right", "bob": "other"})
    reasons = []
    for username, password in (("ann", b"right"), ("ann", b"other"), ("eve", b"right"), ("ann", None), (None, None)):
        client = stranger(version, at=state)
        client.send(mqtt.Connect("a", version, username=username, password=password))
        reasons.append(client.take_only(mqtt.Connack)[0].reason)
    bad = mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD
    assert reasons == [mqtt.ReasonCode.SUCCESS, bad, bad, bad, mqtt.ReasonCode.NOT_AUTHORIZED]
    assert state.stats.connections_refused == 4


def test_one_client_too_many_is_refused_but_a_take_over_is_not(
    new_state: NewState, join: Join, stranger: Stranger
) -> None:
    state = new_state(max_connections=1)
    join("a", at=state)
    client = stranger(at=state)
    client.send(mqtt.Connect("b"))
    assert client.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.QUOTA_EXCEEDED
    join("a", at=state)


def test_extended_authentication_is_refused(stranger: Stranger, join: Join) -> None:
    client = stranger()
    client.send(mqtt.Connect("a", properties=mqtt.Properties(authentication_method="SCRAM")))
    assert client.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.BAD_AUTHENTICATION_METHOD
    client = join()
    client.send(mqtt.Auth(mqtt.ReasonCode.REAUTHENTICATE))
    assert client.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.BAD_AUTHENTICATION_METHOD


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("10 0c 00 04 4d 51 54 54 06 02 00 00 00 00", "20 03 00 84 00"),  # MQTT 6
        ("10 0c 00 04 4d 51 54 54 03 02 00 00 00 00", "20 02 00 01"),
        ("10 0a 00 02 68 6a 04 02 00 00 00 00", "20 02 00 01"),  # another protocol
        ("10 0d 00 04 4d 51 54 54 05 03 00 00 00 00 00", "20 03 00 81 00"),  # reserved flag
        ("10 0c 00 04 4d 51 54 54 04 03 00 00 00 00", ""),
        ("c0 00", ""),  # not CONNECT
        ("47 45 54 20 2f 20 48 54 54 50", ""),  # GET / HTTP
        ("10 ff ff 7f", ""),  # too large for a CONNECT
    ],
)
def test_what_is_no_connect_is_answered_as_far_as_it_can_be_and_closed(
    stranger: Stranger, text: str, answer: str
) -> None:
    client = stranger()
    client.send_bytes(bytes.fromhex(text))
    assert client.link.written.hex(" ") == answer
    assert client.link.closed


@pytest.mark.parametrize(
    ("packet", "reason"),
    [
        (mqtt.Connect("a"), mqtt.ReasonCode.PROTOCOL_ERROR),
        (mqtt.Connack(), mqtt.ReasonCode.PROTOCOL_ERROR),
        (mqtt.Pingresp(), mqtt.ReasonCode.PROTOCOL_ERROR),
        (mqtt.Publish("a", properties=mqtt.Properties(subscription_identifiers=(1,))), mqtt.ReasonCode.PROTOCOL_ERROR),
        (mqtt.Publish("a/" * 200), mqtt.ReasonCode.TOPIC_NAME_INVALID),
    ],
)
def test_a_packet_that_must_not_come_ends_the_connection_with_a_reason(
    join: Join, packet: mqtt.Packet, reason: mqtt.ReasonCode
) -> None:
    client = join()
    client.send(packet)
    (goodbye,) = client.take_only(mqtt.Disconnect)
    assert goodbye.reason is reason
    assert goodbye.properties.reason_string
    assert client.link.closed
    assert client.link.lingers
    assert client.state.stats.clients == 0


def test_an_older_client_is_just_closed(join: Join) -> None:
    client = join(version=V311)
    client.send_bytes(b"\x36\x00")
    assert client.take() == []
    assert client.link.closed


def test_reasons_in_words_are_left_out_on_request_or_for_want_of_room(join: Join) -> None:
    for wish in ({"request_problem_information": 0}, {"maximum_packet_size": 20}):
        client = join(**wish)
        client.send_bytes(b"\xc0\x01\x00")
        assert client.take() == [mqtt.Disconnect(mqtt.ReasonCode.MALFORMED_PACKET)]


def test_nothing_is_read_behind_a_disconnect(join: Join) -> None:
    client = join(will=mqtt.Will("t"))
    client.send(mqtt.Disconnect(), mqtt.Publish("t", retain=True))
    assert client.state.stats.retained_messages == 0
    assert client.link.closed
    assert not client.link.lingers


def test_a_silent_client_is_closed_after_one_and_a_half_keep_alives(join: Join, pass_time: PassTime) -> None:
    client = join(keep_alive=10, will=mqtt.Will("w", b"gone", retain=True))
    pass_time(14)
    client.send(mqtt.Pingreq())
    client.take()
    pass_time(14.9)
    assert not client.link.closed
    pass_time(0.1)
    assert client.take_only(mqtt.Disconnect)[0].reason is mqtt.ReasonCode.KEEP_ALIVE_TIMEOUT
    assert client.state.stats.retained_messages == 1


def test_a_client_without_keep_alive_may_be_silent_for_ever(join: Join, pass_time: PassTime) -> None:
    client = join(keep_alive=0)
    pass_time(1e6)
    assert not client.link.closed


def test_a_socket_without_connect_is_closed(stranger: Stranger, pass_time: PassTime) -> None:
    client = stranger()
    client.send_bytes(b"\x10")
    pass_time(10)
    assert client.link.closed


def test_a_policy_refuses_publishes_subscriptions_and_wills(
    new_state: NewState, join: Join, stranger: Stranger
) -> None:
    state = new_state(policy=Gatekeeper())
    client, older = join("a", at=state), join("b", at=state, version=V311)
    assert client.subscribe(mqtt.MqttSubscription("secret/#"), "#") == (
        mqtt.ReasonCode.NOT_AUTHORIZED,
        mqtt.ReasonCode.GRANTED_QOS_2,
    )
    for qos in (0, 1, 2):
        client.publish("secret/x", qos=qos, packet_id=qos or None)
        older.publish("secret/x", qos=qos, packet_id=qos or None)
    denied = mqtt.ReasonCode.NOT_AUTHORIZED
    assert client.take() == [mqtt.Puback(1, denied), mqtt.Pubrec(2, denied)]
    assert older.take() == [mqtt.Puback(1), mqtt.Pubrec(2)]
    assert state.stats.dropped_refused == 6
    client = stranger(at=state)
    client.send(mqtt.Connect("c", will=mqtt.Will("secret/x")))
    assert client.take_only(mqtt.Connack)[0].reason is denied


@pytest.mark.parametrize("version", [V311, V5])
def test_clients_publish_nothing_for_the_broker(join: Join, version: mqtt.ProtocolVersion) -> None:
    """Else one could pass for it: a version, an uptime, a load."""
    listener, client = join("listener", to="$SYS/#"), join("client", version=version)
    for qos in (0, 1, 2):
        client.publish("$SYS/broker/version", b"fake", qos=qos, packet_id=qos or None)
    reason = mqtt.ReasonCode.NOT_AUTHORIZED if version is V5 else mqtt.ReasonCode.SUCCESS
    assert client.take() == [mqtt.Puback(1, reason), mqtt.Pubrec(2, reason)]
    assert listener.take() == []


def test_a_bridge_may_say_that_it_is_connected(join: Join, stranger: Stranger) -> None:
    """As Mosquitto's does where it is not told otherwise, and its will that it is not."""
    state = "$SYS/broker/connection/hall/state"
    listener, bridge = join("listener"), stranger()
    listener.subscribe("$SYS/#")
    bridge.send(mqtt.Connect("hall", will=mqtt.Will(state, b"0")))
    assert bridge.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.SUCCESS
    bridge.publish(state, b"1", retain=True)
    assert [(each.topic, each.payload) for each in listener.take_only(mqtt.Publish)] == [(state, b"1")]


def test_a_suback_comes_before_the_retained_messages(join: Join) -> None:
    client = join()
    client.publish("t", retain=True)
    client.send(mqtt.Subscribe(5, (mqtt.MqttSubscription("t"),)))
    assert [type(packet) for packet in client.take()] == [mqtt.Suback, mqtt.Publish]


def test_the_words_of_a_reason_are_short_however_long_the_culprit(join: Join) -> None:
    client = join()
    client.send(mqtt.Subscribe(1, (mqtt.MqttSubscription("a" * 65_000 + "#"),)))
    (goodbye,) = client.take_only(mqtt.Disconnect)
    assert goodbye.reason is mqtt.ReasonCode.TOPIC_FILTER_INVALID
    assert len(goodbye.properties.reason_string or "") <= 200


def test_a_will_too_deep_is_refused(stranger: Stranger) -> None:
    client = stranger()
    client.send(mqtt.Connect("a", will=mqtt.Will("a/" * 200)))
    assert client.take_only(mqtt.Connack)[0].reason is mqtt.ReasonCode.TOPIC_NAME_INVALID
