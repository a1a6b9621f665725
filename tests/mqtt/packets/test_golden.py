"""Packets whose bytes were worked out by hand from the standards, both ways."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.mqtt.packets import (
    Auth,
    Connack,
    Connect,
    Disconnect,
    MqttSubscription,
    Packet,
    PacketReader,
    Pingreq,
    Pingresp,
    Properties,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    ReasonCode,
    Suback,
    Subscribe,
    Unsuback,
    Unsubscribe,
    Will,
    encode,
)

V31, V311, V5 = ProtocolVersion.V31, ProtocolVersion.V311, ProtocolVersion.V5

GOLDEN: list[tuple[ProtocolVersion, str, Packet]] = [
    (V31, "10 0f 00 06 4d 51 49 73 64 70 03 02 00 3c 00 01 61", Connect("a", V31)),
    (V311, "10 0d 00 04 4d 51 54 54 04 02 00 3c 00 01 61", Connect("a", V311)),
    (V31, "10 0f 00 06 4d 51 49 73 64 70 83 02 00 3c 00 01 61", Connect("a", V31, is_bridge=True)),
    (V311, "10 0d 00 04 4d 51 54 54 84 02 00 3c 00 01 61", Connect("a", V311, is_bridge=True)),
    (V5, "10 0e 00 04 4d 51 54 54 05 02 00 3c 00 00 01 61", Connect("a")),
    (
        V311,
        "10 1b 00 04 4d 51 54 54 04 ee 00 00 00 01 61 00 01 77 00 02 68 69 00 01 75 00 02 70 77",
        Connect("a", V311, True, 0, "u", b"pw", Will("w", b"hi", 1, True)),
    ),
    (
        V5,
        "10 1e 00 04 4d 51 54 54 05 04 00 0a 05 11 00 00 00 3c 00 01 61 05 18 00 00 00 05 00 01 77 00 00",
        Connect(
            "a",
            V5,
            False,
            10,
            will=Will("w", properties=Properties(will_delay_interval=5)),
            properties=Properties(session_expiry_interval=60),
        ),
    ),
    (
        V5,
        "10 12 00 04 4d 51 54 54 05 02 00 3c 04 17 00 19 01 00 01 61",
        Connect("a", properties=Properties(request_problem_information=0, request_response_information=1)),
    ),
    (V311, "20 02 01 00", Connack(session_present=True)),
    (V311, "20 02 00 04", Connack(reason=ReasonCode.BAD_USER_NAME_OR_PASSWORD)),
    (V311, "20 02 00 01", Connack(reason=ReasonCode.UNSUPPORTED_PROTOCOL_VERSION)),
    (V5, "20 03 00 86 00", Connack(reason=ReasonCode.BAD_USER_NAME_OR_PASSWORD)),
    (V5, "20 06 01 00 03 21 00 14", Connack(True, properties=Properties(receive_maximum=20))),
    (
        V5,
        "20 0d 00 00 0a 1a 00 01 72 28 00 29 00 2a 00",
        Connack(
            properties=Properties(
                response_information="r",
                wildcard_subscription_available=0,
                subscription_identifier_available=0,
                shared_subscription_available=0,
            )
        ),
    ),
    (V311, "30 05 00 03 61 2f 62", Publish("a/b")),
    (V311, "3d 08 00 01 61 00 07 6f 66 66", Publish("a", b"off", 2, True, True, 7)),
    (V5, "32 07 00 01 61 00 07 00 78", Publish("a", b"x", 1, packet_id=7)),
    (
        V5,
        "30 0c 00 01 61 08 02 00 00 00 0a 23 00 05",
        Publish("a", properties=Properties(message_expiry_interval=10, topic_alias=5)),
    ),
    (V311, "40 02 12 34", Puback(0x1234)),
    (V5, "40 03 00 01 10", Puback(1, ReasonCode.NO_MATCHING_SUBSCRIBERS)),
    (V5, "50 08 00 01 97 04 1f 00 01 6e", Pubrec(1, ReasonCode.QUOTA_EXCEEDED, Properties(reason_string="n"))),
    (V311, "62 02 00 01", Pubrel(1)),
    (V5, "62 03 00 01 92", Pubrel(1, ReasonCode.PACKET_IDENTIFIER_NOT_FOUND)),
    (V311, "70 02 00 01", Pubcomp(1)),
    (V311, "82 08 00 01 00 03 61 2f 23 02", Subscribe(1, (MqttSubscription("a/#", 2),))),
    (
        V5,
        "82 09 00 01 02 0b 05 00 01 61 2d",
        Subscribe(1, (MqttSubscription("a", 1, True, True, 2),), Properties(subscription_identifiers=(5,))),
    ),
    (V311, "90 04 00 01 00 80", Suback(1, (ReasonCode.SUCCESS, ReasonCode.UNSPECIFIED_ERROR))),
    (V5, "90 05 00 01 00 02 87", Suback(1, (ReasonCode.GRANTED_QOS_2, ReasonCode.NOT_AUTHORIZED))),
    (V311, "a2 05 00 01 00 01 61", Unsubscribe(1, ("a",))),
    (V5, "a2 06 00 01 00 00 01 61", Unsubscribe(1, ("a",))),
    (V311, "b0 02 00 01", Unsuback(1)),
    (V5, "b0 04 00 01 00 11", Unsuback(1, (ReasonCode.NO_SUBSCRIPTION_EXISTED,))),
    (V311, "c0 00", Pingreq()),
    (V311, "d0 00", Pingresp()),
    (V311, "e0 00", Disconnect()),
    (V5, "e0 00", Disconnect()),
    (V5, "e0 01 8e", Disconnect(ReasonCode.SESSION_TAKEN_OVER)),
    (V5, "e0 07 00 05 11 00 00 00 05", Disconnect(properties=Properties(session_expiry_interval=5))),
    (V5, "f0 06 18 04 15 00 01 6d", Auth(ReasonCode.CONTINUE_AUTHENTICATION, Properties(authentication_method="m"))),
]


@pytest.mark.parametrize(("version", "text", "packet"), GOLDEN)
def test_a_packet_becomes_these_bytes(version: ProtocolVersion, text: str, packet: Packet) -> None:
    assert encode(packet, version).hex(" ") == text


@pytest.mark.parametrize(("version", "text", "packet"), GOLDEN)
def test_these_bytes_become_the_packet(version: ProtocolVersion, text: str, packet: Packet) -> None:
    reader = PacketReader(version)
    assert list(reader.feed(bytes.fromhex(text))) == [packet]


def test_a_reason_unknown_before_mqtt_5_becomes_the_nearest() -> None:
    assert encode(Connack(reason=ReasonCode.QUOTA_EXCEEDED), V311).hex(" ") == "20 02 00 03"
    assert encode(Suback(1, (ReasonCode.NOT_AUTHORIZED,)), V311).hex(" ") == "90 03 00 01 80"
    assert encode(Puback(1, ReasonCode.QUOTA_EXCEEDED), V311).hex(" ") == "40 02 00 01"


def test_mqtt_3_1_has_no_session_present_flag() -> None:
    assert encode(Connack(session_present=True), V31).hex(" ") == "20 02 00 00"


@pytest.mark.parametrize(
    ("packet", "version"),
    [
        (Publish("a", qos=1), V5),
        (Publish("a", qos=0, packet_id=1), V5),
        (Publish("a", qos=1, packet_id=65_536), V5),
        (Publish("a" * 65_536), V5),
        (Publish("a\0"), V5),
        (Publish("\ud800"), V5),
        (Publish("a", properties=Properties(receive_maximum=1)), V5),
        (Publish("a", properties=Properties(topic_alias=65_536)), V5),
        (Publish("a", properties=Properties(payload_format_indicator=256)), V5),
        (Publish("a", properties=Properties(message_expiry_interval=-1)), V5),
        (Publish("a", properties=Properties(subscription_identifiers=(2**28,))), V5),
        (Connect("a", V311, password=b"p"), V311),
        (Connect("a", V5, is_bridge=True), V5),
        (Subscribe(1, ()), V5),
        (Unsubscribe(1, ()), V5),
        (Auth(), V311),
    ],
)
def test_a_value_that_does_not_fit_its_field_is_our_mistake(packet: Packet, version: ProtocolVersion) -> None:
    with pytest.raises(UsageError):
        encode(packet, version)


def test_a_password_is_not_shown() -> None:
    assert "secret" not in repr(Connect("a", username="u", password=b"secret"))
