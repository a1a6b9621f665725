"""Packets whose bytes were worked out by hand from the standards, both ways; and a round trip in older versions."""

from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.packets.test_every_type_against_mqtt5 import PACKETS

from homebot.errors import UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.packets.primitives import Cursor
from homebot.mqtt.packets.properties import _TABLE, decode_properties, encode_properties

V31, V311, V5 = mqtt.ProtocolVersion.V31, mqtt.ProtocolVersion.V311, mqtt.ProtocolVersion.V5

GOLDEN: list[tuple[mqtt.ProtocolVersion, str, mqtt.Packet]] = [
    (V31, "10 0f 00 06 4d 51 49 73 64 70 03 02 00 3c 00 01 61", mqtt.Connect("a", V31)),
    (V311, "10 0d 00 04 4d 51 54 54 04 02 00 3c 00 01 61", mqtt.Connect("a", V311)),
    (V31, "10 0f 00 06 4d 51 49 73 64 70 83 02 00 3c 00 01 61", mqtt.Connect("a", V31, is_bridge=True)),
    (V311, "10 0d 00 04 4d 51 54 54 84 02 00 3c 00 01 61", mqtt.Connect("a", V311, is_bridge=True)),
    (V5, "10 0e 00 04 4d 51 54 54 05 02 00 3c 00 00 01 61", mqtt.Connect("a")),
    (
        V311,
        "10 1b 00 04 4d 51 54 54 04 ee 00 00 00 01 61 00 01 77 00 02 68 69 00 01 75 00 02 70 77",
        mqtt.Connect("a", V311, True, 0, "u", b"pw", mqtt.Will("w", b"hi", 1, True)),
    ),
    (
        V5,
        "10 1e 00 04 4d 51 54 54 05 04 00 0a 05 11 00 00 00 3c 00 01 61 05 18 00 00 00 05 00 01 77 00 00",
        mqtt.Connect(
            "a",
            V5,
            False,
            10,
            will=mqtt.Will("w", properties=mqtt.Properties(will_delay_interval=5)),
            properties=mqtt.Properties(session_expiry_interval=60),
        ),
    ),
    (
        V5,
        "10 12 00 04 4d 51 54 54 05 02 00 3c 04 17 00 19 01 00 01 61",
        mqtt.Connect("a", properties=mqtt.Properties(request_problem_information=0, request_response_information=1)),
    ),
    (V311, "20 02 01 00", mqtt.Connack(session_present=True)),
    (V311, "20 02 00 04", mqtt.Connack(reason=mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD)),
    (V311, "20 02 00 01", mqtt.Connack(reason=mqtt.ReasonCode.UNSUPPORTED_PROTOCOL_VERSION)),
    (V5, "20 03 00 86 00", mqtt.Connack(reason=mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD)),
    (V5, "20 06 01 00 03 21 00 14", mqtt.Connack(True, properties=mqtt.Properties(receive_maximum=20))),
    (
        V5,
        "20 0d 00 00 0a 1a 00 01 72 28 00 29 00 2a 00",
        mqtt.Connack(
            properties=mqtt.Properties(
                response_information="r",
                wildcard_subscription_available=0,
                subscription_identifier_available=0,
                shared_subscription_available=0,
            )
        ),
    ),
    (V311, "30 05 00 03 61 2f 62", mqtt.Publish("a/b")),
    (V311, "3d 08 00 01 61 00 07 6f 66 66", mqtt.Publish("a", b"off", 2, True, True, 7)),
    (V5, "32 07 00 01 61 00 07 00 78", mqtt.Publish("a", b"x", 1, packet_id=7)),
    (
        V5,
        "30 0c 00 01 61 08 02 00 00 00 0a 23 00 05",
        mqtt.Publish("a", properties=mqtt.Properties(message_expiry_interval=10, topic_alias=5)),
    ),
    (V311, "40 02 12 34", mqtt.Puback(0x1234)),
    (V5, "40 03 00 01 10", mqtt.Puback(1, mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS)),
    (
        V5,
        "50 08 00 01 97 04 1f 00 01 6e",
        mqtt.Pubrec(1, mqtt.ReasonCode.QUOTA_EXCEEDED, mqtt.Properties(reason_string="n")),
    ),
    (V311, "62 02 00 01", mqtt.Pubrel(1)),
    (V5, "62 03 00 01 92", mqtt.Pubrel(1, mqtt.ReasonCode.PACKET_IDENTIFIER_NOT_FOUND)),
    (V311, "70 02 00 01", mqtt.Pubcomp(1)),
    (V311, "82 08 00 01 00 03 61 2f 23 02", mqtt.Subscribe(1, (mqtt.MqttSubscription("a/#", 2),))),
    (
        V5,
        "82 09 00 01 02 0b 05 00 01 61 2d",
        mqtt.Subscribe(
            1, (mqtt.MqttSubscription("a", 1, True, True, 2),), mqtt.Properties(subscription_identifiers=(5,))
        ),
    ),
    (V311, "90 04 00 01 00 80", mqtt.Suback(1, (mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.UNSPECIFIED_ERROR))),
    (V5, "90 05 00 01 00 02 87", mqtt.Suback(1, (mqtt.ReasonCode.GRANTED_QOS_2, mqtt.ReasonCode.NOT_AUTHORIZED))),
    (V311, "a2 05 00 01 00 01 61", mqtt.Unsubscribe(1, ("a",))),
    (V5, "a2 06 00 01 00 00 01 61", mqtt.Unsubscribe(1, ("a",))),
    (V311, "b0 02 00 01", mqtt.Unsuback(1)),
    (V5, "b0 04 00 01 00 11", mqtt.Unsuback(1, (mqtt.ReasonCode.NO_SUBSCRIPTION_EXISTED,))),
    (V311, "c0 00", mqtt.Pingreq()),
    (V311, "d0 00", mqtt.Pingresp()),
    (V311, "e0 00", mqtt.Disconnect()),
    (V5, "e0 00", mqtt.Disconnect()),
    (V5, "e0 01 8e", mqtt.Disconnect(mqtt.ReasonCode.SESSION_TAKEN_OVER)),
    (V5, "e0 07 00 05 11 00 00 00 05", mqtt.Disconnect(properties=mqtt.Properties(session_expiry_interval=5))),
    (
        V5,
        "f0 06 18 04 15 00 01 6d",
        mqtt.Auth(mqtt.ReasonCode.CONTINUE_AUTHENTICATION, mqtt.Properties(authentication_method="m")),
    ),
]


@pytest.mark.parametrize(("version", "text", "packet"), GOLDEN)
def test_a_packet_becomes_these_bytes(version: mqtt.ProtocolVersion, text: str, packet: mqtt.Packet) -> None:
    assert mqtt.encode(packet, version).hex(" ") == text


@pytest.mark.parametrize(("version", "text", "packet"), GOLDEN)
def test_these_bytes_become_the_packet(version: mqtt.ProtocolVersion, text: str, packet: mqtt.Packet) -> None:
    reader = mqtt.PacketReader(version)
    assert list(reader.feed(bytes.fromhex(text))) == [packet]


def test_a_reason_unknown_before_mqtt_5_becomes_the_nearest() -> None:
    assert mqtt.encode(mqtt.Connack(reason=mqtt.ReasonCode.QUOTA_EXCEEDED), V311).hex(" ") == "20 02 00 03"
    assert mqtt.encode(mqtt.Suback(1, (mqtt.ReasonCode.NOT_AUTHORIZED,)), V311).hex(" ") == "90 03 00 01 80"
    assert mqtt.encode(mqtt.Puback(1, mqtt.ReasonCode.QUOTA_EXCEEDED), V311).hex(" ") == "40 02 00 01"


def test_mqtt_3_1_has_no_session_present_flag() -> None:
    assert mqtt.encode(mqtt.Connack(session_present=True), V31).hex(" ") == "20 02 00 00"


@pytest.mark.parametrize(
    ("packet", "version"),
    [
        (mqtt.Publish("a", qos=1), V5),
        (mqtt.Publish("a", qos=0, packet_id=1), V5),
        (mqtt.Publish("a", qos=1, packet_id=65_536), V5),
        (mqtt.Publish("a" * 65_536), V5),
        (mqtt.Publish("a\0"), V5),
        (mqtt.Publish("\ud800"), V5),
        (mqtt.Publish("a", properties=mqtt.Properties(receive_maximum=1)), V5),
        (mqtt.Publish("a", properties=mqtt.Properties(topic_alias=65_536)), V5),
        (mqtt.Publish("a", properties=mqtt.Properties(payload_format_indicator=256)), V5),
        (mqtt.Publish("a", properties=mqtt.Properties(message_expiry_interval=-1)), V5),
        (mqtt.Publish("a", properties=mqtt.Properties(subscription_identifiers=(2**28,))), V5),
        (mqtt.Connect("a", V311, password=b"p"), V311),
        (mqtt.Connect("a", V5, is_bridge=True), V5),
        (mqtt.Subscribe(1, ()), V5),
        (mqtt.Unsubscribe(1, ()), V5),
        (mqtt.Auth(), V311),
    ],
)
def test_a_value_that_does_not_fit_its_field_is_our_mistake(packet: mqtt.Packet, version: mqtt.ProtocolVersion) -> None:
    with pytest.raises(UsageError):
        mqtt.encode(packet, version)


def test_a_password_is_not_shown() -> None:
    assert "secret" not in repr(mqtt.Connect("a", username="u", password=b"secret"))


@given(
    PACKETS["PUBLISH"],
    st.sampled_from([mqtt.ProtocolVersion.V31, mqtt.ProtocolVersion.V311]),
)
def test_a_message_survives_older_versions_without_its_properties(
    packet: mqtt.Publish, version: mqtt.ProtocolVersion
) -> None:
    expected = packet._replace(properties=mqtt.NO_PROPERTIES)
    assert list(mqtt.PacketReader(version).feed(mqtt.encode(packet, version))) == [expected]


def test_a_topic_may_be_longer_than_255_bytes() -> None:
    packet = mqtt.Publish("t" * 700, b"x")
    assert mqtt.encode(packet)[3:5] == b"\x02\xbc"
    assert list(mqtt.PacketReader().feed(mqtt.encode(packet))) == [packet]


def test_the_table_has_every_property_once() -> None:
    names = [row.name for row in _TABLE]
    assert sorted(names) == sorted(field.name for field in fields(mqtt.Properties))
    assert len({row.number for row in _TABLE}) == len(_TABLE)


def test_a_message_may_carry_several_subscription_identifiers() -> None:
    properties = mqtt.Properties(subscription_identifiers=(1, 300, 2**28 - 1))
    raw = encode_properties(properties, mqtt.PacketType.PUBLISH)
    assert decode_properties(Cursor(raw), mqtt.PacketType.PUBLISH) == properties
