"""Every type of packet against the mqtt5 package: it reads what we write, and we read what it writes as the same."""

from __future__ import annotations

import mqtt5
import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt import packets as mqtt

pytestmark = pytest.mark.slow

TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0+#$"), min_size=1, max_size=8)
IDS = st.integers(1, 0xFFFF)
PAIRS = st.lists(st.tuples(TEXT, TEXT), max_size=2).map(tuple)
WORDS = st.builds(mqtt.Properties, reason_string=st.none() | TEXT, user_properties=PAIRS)
SECONDS = st.integers(1, 2**32 - 1)

PUBLISH_REASONS = st.sampled_from(
    [
        mqtt.ReasonCode.SUCCESS,
        mqtt.ReasonCode.NO_MATCHING_SUBSCRIBERS,
        mqtt.ReasonCode.NOT_AUTHORIZED,
        mqtt.ReasonCode.QUOTA_EXCEEDED,
    ]
)
RELEASE_REASONS = st.sampled_from([mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.PACKET_IDENTIFIER_NOT_FOUND])
SUBACK_REASONS = st.sampled_from(
    [mqtt.ReasonCode(code) for code in (0, 1, 2, 0x80, 0x83, 0x87, 0x8F, 0x97, 0x9E, 0xA2)]
)

# Values that are the default are left out by one side and written by the other, so they are not made here.
PACKETS: dict[str, st.SearchStrategy[mqtt.Packet]] = {
    "CONNECT": st.builds(
        mqtt.Connect,
        TEXT,
        st.just(mqtt.ProtocolVersion.V5),
        st.booleans(),
        st.integers(0, 0xFFFF),
        st.none() | TEXT,
        st.none() | st.binary(max_size=8),
        st.none() | st.builds(mqtt.Will, TEXT, st.binary(max_size=8), st.integers(0, 2), st.booleans()),
        st.builds(
            mqtt.Properties,
            session_expiry_interval=st.none() | SECONDS,
            receive_maximum=st.none() | st.integers(1, 0xFFFE),
            maximum_packet_size=st.none() | SECONDS,
            topic_alias_maximum=st.none() | IDS,
            authentication_method=TEXT,
            authentication_data=st.none() | st.binary(max_size=8),
            user_properties=PAIRS,
        ),
    ),
    "CONNACK": st.builds(
        mqtt.Connack,
        st.just(False),
        st.sampled_from(
            [mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.BAD_USER_NAME_OR_PASSWORD, mqtt.ReasonCode.PACKET_TOO_LARGE]
        ),
        st.builds(
            mqtt.Properties,
            session_expiry_interval=st.none() | SECONDS,
            receive_maximum=st.none() | st.integers(1, 0xFFFE),
            maximum_qos=st.none() | st.integers(0, 1),
            retain_available=st.none() | st.just(0),
            maximum_packet_size=st.none() | SECONDS,
            assigned_client_identifier=st.none() | TEXT,
            topic_alias_maximum=st.none() | IDS,
            reason_string=st.none() | TEXT,
            user_properties=PAIRS,
            server_keep_alive=st.none() | IDS,
            server_reference=st.none() | TEXT,
        ),
    ),
    "PUBLISH": st.builds(
        lambda topic, payload, qos, flags, packet_id, properties: mqtt.Publish(
            topic, payload, qos, flags[0], flags[1] and qos > 0, packet_id if qos else None, properties
        ),
        TEXT,
        st.binary(max_size=300),
        st.integers(0, 2),
        st.tuples(st.booleans(), st.booleans()),
        IDS,
        st.builds(
            mqtt.Properties,
            payload_format_indicator=st.none() | st.just(1),
            message_expiry_interval=st.none() | st.integers(0, 2**32 - 1),
            content_type=st.none() | TEXT,
            response_topic=st.none() | TEXT,
            correlation_data=st.none() | st.binary(max_size=9),
            topic_alias=st.none() | IDS,
            user_properties=PAIRS,
        ),
    ),
    "PUBACK": st.builds(mqtt.Puback, IDS, PUBLISH_REASONS, WORDS),
    "PUBREC": st.builds(mqtt.Pubrec, IDS, PUBLISH_REASONS, WORDS),
    "PUBREL": st.builds(mqtt.Pubrel, IDS, RELEASE_REASONS, WORDS),
    "PUBCOMP": st.builds(mqtt.Pubcomp, IDS, RELEASE_REASONS, WORDS),
    "SUBSCRIBE": st.builds(
        mqtt.Subscribe,
        IDS,
        st.lists(
            st.builds(mqtt.MqttSubscription, TEXT, st.integers(0, 2), st.booleans(), st.booleans(), st.integers(0, 2)),
            min_size=1,
            max_size=3,
        ).map(tuple),
        st.builds(
            mqtt.Properties,
            subscription_identifiers=st.just(()) | st.tuples(st.integers(1, 2**28 - 1)),
            user_properties=PAIRS,
        ),
    ),
    "SUBACK": st.builds(mqtt.Suback, IDS, st.lists(SUBACK_REASONS, min_size=1, max_size=4).map(tuple), WORDS),
    "UNSUBSCRIBE": st.builds(
        mqtt.Unsubscribe,
        IDS,
        st.lists(TEXT, min_size=1, max_size=3).map(tuple),
        st.builds(mqtt.Properties, user_properties=PAIRS),
    ),
    "UNSUBACK": st.builds(
        mqtt.Unsuback,
        IDS,
        st.lists(
            st.sampled_from(
                [mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.NO_SUBSCRIPTION_EXISTED, mqtt.ReasonCode.NOT_AUTHORIZED]
            ),
            min_size=1,
        ).map(tuple),
        WORDS,
    ),
    "PINGREQ": st.just(mqtt.Pingreq()),
    "PINGRESP": st.just(mqtt.Pingresp()),
    "DISCONNECT": st.builds(
        mqtt.Disconnect,
        st.sampled_from(
            [mqtt.ReasonCode.SUCCESS, mqtt.ReasonCode.DISCONNECT_WITH_WILL, mqtt.ReasonCode.SESSION_TAKEN_OVER]
        ),
        st.builds(
            mqtt.Properties,
            session_expiry_interval=st.none() | SECONDS,
            reason_string=st.none() | TEXT,
            server_reference=st.none() | TEXT,
            user_properties=PAIRS,
        ),
    ),
    "AUTH": st.builds(
        mqtt.Auth,
        st.sampled_from([mqtt.ReasonCode.CONTINUE_AUTHENTICATION, mqtt.ReasonCode.REAUTHENTICATE]),
        st.builds(
            mqtt.Properties,
            authentication_method=TEXT,
            authentication_data=st.none() | st.binary(max_size=8),
            reason_string=st.none() | TEXT,
            user_properties=PAIRS,
        ),
    ),
}


@pytest.mark.parametrize("name", PACKETS)
@given(data=st.data())
def test_both_agree(name: str, data: st.DataObject) -> None:
    packet = data.draw(PACKETS[name])
    raw = mqtt.encode(packet)
    theirs, size = mqtt5.read(memoryview(raw))
    assert size == len(raw)
    assert list(mqtt.PacketReader().feed(theirs.write())) == [packet]
