"""Bytes that are no packet, and the reason code each is refused with."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.packets import PacketError, PacketReader, ProtocolVersion, ReasonCode, decode

V31, V311, V5 = ProtocolVersion.V31, ProtocolVersion.V311, ProtocolVersion.V5
MALFORMED, PROTOCOL = ReasonCode.MALFORMED_PACKET, ReasonCode.PROTOCOL_ERROR


@pytest.mark.parametrize(
    ("version", "text", "code"),
    [
        (V5, "00 00", MALFORMED),  # type 0
        (V311, "f0 00", MALFORMED),  # AUTH before MQTT 5
        (V5, "c1 00", MALFORMED),  # PINGREQ with flags
        (V5, "c0 01 00", MALFORMED),  # PINGREQ with a body
        (V5, "60 02 00 01", MALFORMED),  # PUBREL without its flags
        (V5, "80 06 00 01 00 00 01 61", MALFORMED),  # SUBSCRIBE without its flags
        (V5, "30 ff ff ff ff", MALFORMED),  # length of five bytes
        (V5, "30 80 00", MALFORMED),  # length longer than needed
        (V5, "36 06 00 01 61 00 01 00", MALFORMED),  # QoS 3
        (V311, "38 03 00 01 61", MALFORMED),  # DUP at QoS 0
        (V5, "30 01 00", MALFORMED),  # cut before the topic
        (V5, "30 03 00 05 61", MALFORMED),  # topic longer than the packet
        (V5, "32 04 00 01 61 00", MALFORMED),  # cut in the packet id
        (V5, "32 06 00 01 61 00 00 00", PROTOCOL),  # packet id 0
        (V5, "30 04 00 01 ff 00", MALFORMED),  # not UTF-8
        (V5, "30 06 00 03 ed a0 80 00", MALFORMED),  # a surrogate
        (V5, "30 04 00 01 00 00", MALFORMED),  # NUL in the topic
        (V5, "30 04 00 01 2b 00", ReasonCode.TOPIC_NAME_INVALID),  # wildcard
        (V311, "30 02 00 00", PROTOCOL),  # no topic
        (V5, "30 03 00 00 00", PROTOCOL),  # no topic and no alias
        (V5, "30 07 00 01 61 03 23 00 00", ReasonCode.TOPIC_ALIAS_INVALID),  # alias 0
        (V5, "30 06 00 01 61 02 01 02", PROTOCOL),  # payload format 2
        (V5, "30 08 00 01 61 04 01 00 01 00", PROTOCOL),  # twice the same
        (V5, "30 06 00 01 61 02 7f 00", MALFORMED),  # unknown property
        (V5, "30 07 00 01 61 03 21 00 01", PROTOCOL),  # a property of CONNECT
        (V5, "30 05 00 01 61 02 01", MALFORMED),  # properties longer than the packet
        (V5, "30 06 00 01 61 01 01 00", MALFORMED),  # a property past their length
        (V5, "30 08 00 01 61 04 08 00 01 23", PROTOCOL),  # wildcard in the response topic
        (V5, "30 06 00 01 61 02 0b 00", PROTOCOL),  # subscription identifier 0
        (V5, "40 01 00", MALFORMED),
        (V5, "40 02 00 00", PROTOCOL),
        (V311, "40 03 00 01 00", MALFORMED),
        (V5, "40 03 00 01 92", PROTOCOL),  # a reason of PUBCOMP
        (V5, "40 05 00 01 00 00 00", MALFORMED),  # something behind the properties
        (V311, "6a 02 00 01", MALFORMED),  # DUP, which MQTT 3.1 alone has there
        (V31, "60 02 00 01", MALFORMED),  # PUBREL at QoS 0
        (V311, "82 02 00 01", PROTOCOL),  # no filter
        (V311, "82 05 00 00 00 01 61", PROTOCOL),  # packet id 0, and cut
        (V311, "82 06 00 01 00 01 61 03", MALFORMED),  # QoS 3
        (V311, "82 06 00 01 00 01 61 04", MALFORMED),  # an option of MQTT 5
        (V5, "82 07 00 01 00 00 01 61 40", MALFORMED),  # reserved option
        (V5, "82 07 00 01 00 00 01 61 30", PROTOCOL),  # retain handling 3
        (V311, "82 08 00 01 00 03 61 2b 62 00", ReasonCode.TOPIC_FILTER_INVALID),
        (V311, "82 05 00 01 00 00 00", ReasonCode.TOPIC_FILTER_INVALID),  # empty filter
        (V5, "82 11 00 01 00 00 0b 24 73 68 61 72 65 2f 67 2f 61 61 04", PROTOCOL),  # no-local with $share
        (V5, "82 09 00 01 02 0b 00 00 01 61 00", PROTOCOL),  # subscription identifier 0
        (V311, "a2 02 00 01", PROTOCOL),
        (V311, "e0 01 00", MALFORMED),
        (V5, "e0 01 01", PROTOCOL),
        (V5, "f0 01 01", PROTOCOL),
        (V5, "20 03 02 00 00", MALFORMED),
        (V5, "20 03 00 01 00", PROTOCOL),
        (V311, "20 02 00 06", PROTOCOL),
        (V5, "90 03 00 01 00", PROTOCOL),  # no reason
        (V5, "b0 04 00 01 00 01", PROTOCOL),
    ],
)
def test_a_bad_packet_is_refused_with_its_reason(version: ProtocolVersion, text: str, code: ReasonCode) -> None:
    with pytest.raises(PacketError) as caught:
        list(PacketReader(version).feed(bytes.fromhex(text)))
    assert caught.value.code is code


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("00 04 4d 51 54 54 06 02 00 00 00 00", ReasonCode.UNSUPPORTED_PROTOCOL_VERSION),
        ("00 02 68 6a 04 02 00 00 00 00", ReasonCode.UNSUPPORTED_PROTOCOL_VERSION),
        ("00 06 4d 51 49 73 64 70 04 02 00 00 00 00", ReasonCode.UNSUPPORTED_PROTOCOL_VERSION),
        ("00 04 4d 51 54 54 04 03 00 00 00 00", MALFORMED),  # reserved flag
        ("00 04 4d 51 54 54 04 22 00 00 00 00", MALFORMED),  # retained will without will
        ("00 04 4d 51 54 54 04 1e 00 00 00 00 00 01 77 00 00", MALFORMED),  # will at QoS 3
        ("00 04 4d 51 54 54 04 42 00 00 00 00 00 00", MALFORMED),  # password without user
        ("00 04 4d 51 54 54 04 06 00 00 00 00 00 01 23 00 00", ReasonCode.TOPIC_NAME_INVALID),
        ("00 04 4d 51 54 54 04 02 00 00 00 00 00", MALFORMED),  # something behind
        ("00 04 4d 51 54 54 04 02 00 00 00 01 ff", MALFORMED),  # client id not UTF-8
        ("00 04 4d 51 54 54 05 02 00 00 03 21 00 00 00 00", PROTOCOL),  # Receive Maximum 0
        ("00 04 4d 51 54 54 05 02 00 00 05 27 00 00 00 00 00 00", PROTOCOL),  # Maximum Packet Size 0
        ("00 04 4d 51 54 54 05 02 00 00 02 17 02 00 00", PROTOCOL),
    ],
)
def test_a_bad_connect_is_refused_with_its_reason(text: str, code: ReasonCode) -> None:
    with pytest.raises(PacketError) as caught:
        decode(0x10, bytes.fromhex(text), V311)
    assert caught.value.code is code


def test_an_error_shows_the_frame_but_not_all_of_a_long_one() -> None:
    with pytest.raises(PacketError) as caught:
        decode(0x30, b"\xff\xff" + bytes(500), V5)
    assert "ff ff 00" in str(caught.value)
    assert len(str(caught.value)) < 400


@given(st.integers(0, 255), st.binary(max_size=80), st.sampled_from(ProtocolVersion))
def test_any_bytes_are_a_packet_or_a_packet_error(first: int, body: bytes, version: ProtocolVersion) -> None:
    try:
        packet = decode(first, body, version)
    except PacketError:
        return
    assert packet is not None


@pytest.mark.parametrize("text", ["6a 02 00 01", "8a 06 00 01 00 01 61 01", "aa 05 00 01 00 01 61", "c1 00"])
def test_mqtt_31_repeats_with_dup_and_leaves_bits_unused(text: str) -> None:
    data = bytes.fromhex(text)
    assert decode(data[0], data[2:], V31) == decode(data[0] & 0xF0 | (data[0] & 2), data[2:], V31)
