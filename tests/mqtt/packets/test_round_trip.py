"""Every packet survives a round trip, in every version that can express it."""

from __future__ import annotations

from dataclasses import fields

from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.packets import (
    NO_PROPERTIES,
    Auth,
    Connack,
    Connect,
    Disconnect,
    FilterRequest,
    Packet,
    PacketReader,
    PacketType,
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
from homebot.mqtt.packets.primitives import Cursor
from homebot.mqtt.packets.properties import _TABLE, decode_properties, encode_properties

V5 = ProtocolVersion.V5
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=8)
TOPIC = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0+#"), min_size=1, max_size=8)
FILTER = TOPIC.filter(lambda text: not text.startswith("$")) | st.sampled_from(["#", "+/a", "$share/g/a/#"])
UINT16, UINT32 = st.integers(0, 0xFFFF), st.integers(0, 0xFFFF_FFFF)
PACKET_ID = st.integers(1, 0xFFFF)
BINARY = st.binary(max_size=8)
FLAG = st.integers(0, 1)

VALUES: dict[str, st.SearchStrategy[object]] = {
    "payload_format_indicator": FLAG,
    "message_expiry_interval": UINT32,
    "content_type": TEXT,
    "response_topic": TOPIC,
    "correlation_data": BINARY,
    "subscription_identifiers": st.tuples(st.integers(1, 2**28 - 1)),
    "session_expiry_interval": UINT32,
    "assigned_client_identifier": TEXT,
    "server_keep_alive": UINT16,
    "authentication_method": TEXT,
    "authentication_data": BINARY,
    "request_problem_information": FLAG,
    "will_delay_interval": UINT32,
    "request_response_information": FLAG,
    "response_information": TEXT,
    "server_reference": TEXT,
    "reason_string": TEXT,
    "receive_maximum": st.integers(1, 0xFFFF),
    "topic_alias_maximum": UINT16,
    "topic_alias": st.integers(1, 0xFFFF),
    "maximum_qos": FLAG,
    "retain_available": FLAG,
    "user_properties": st.lists(st.tuples(TEXT, TEXT), min_size=1, max_size=3).map(tuple),
    "maximum_packet_size": st.integers(1, 0xFFFF_FFFF),
    "wildcard_subscription_available": FLAG,
    "subscription_identifier_available": FLAG,
    "shared_subscription_available": FLAG,
}


def properties_of(packet: PacketType) -> st.SearchStrategy[Properties]:
    allowed = {row.name: VALUES[row.name] for row in _TABLE if packet in row.packets}
    return st.just(NO_PROPERTIES) | st.fixed_dictionaries({}, optional=allowed).map(
        lambda values: Properties(**values)  # type: ignore[arg-type] # the table has the types
    )


def acknowledgement(kind: type[Puback | Pubrec | Pubrel | Pubcomp]) -> st.SearchStrategy[Packet]:
    codes = [ReasonCode.SUCCESS, ReasonCode.QUOTA_EXCEEDED]
    if kind in (Pubrel, Pubcomp):
        codes = [ReasonCode.SUCCESS, ReasonCode.PACKET_IDENTIFIER_NOT_FOUND]
    return st.builds(kind, PACKET_ID, st.sampled_from(codes), properties_of(PacketType[kind.__name__.upper()]))


QOS0 = st.builds(
    Publish,
    TOPIC,
    BINARY,
    st.just(0),
    st.booleans(),
    st.just(False),
    st.none(),
    properties_of(PacketType.PUBLISH),
)
QOS12 = st.builds(
    Publish,
    TOPIC,
    BINARY,
    st.integers(1, 2),
    st.booleans(),
    st.booleans(),
    PACKET_ID,
    properties_of(PacketType.PUBLISH),
)
WILLS = st.builds(Will, TOPIC, BINARY, st.integers(0, 2), st.booleans(), properties_of(PacketType.WILL))
REQUESTS = st.builds(FilterRequest, FILTER, st.integers(0, 2), st.just(False), st.booleans(), st.integers(0, 2))
PACKETS: st.SearchStrategy[Packet] = st.one_of(
    QOS0,
    QOS12,
    st.builds(
        Connect,
        TEXT,
        st.just(V5),
        st.booleans(),
        UINT16,
        st.none() | TEXT,
        st.none() | BINARY,
        st.none() | WILLS,
        properties_of(PacketType.CONNECT),
    ),
    st.builds(
        Connack,
        st.booleans(),
        st.sampled_from([ReasonCode.SUCCESS, ReasonCode.NOT_AUTHORIZED]),
        properties_of(PacketType.CONNACK),
    ),
    acknowledgement(Puback),
    acknowledgement(Pubrec),
    acknowledgement(Pubrel),
    acknowledgement(Pubcomp),
    st.builds(
        Subscribe,
        PACKET_ID,
        st.lists(REQUESTS, min_size=1, max_size=3).map(tuple),
        properties_of(PacketType.SUBSCRIBE),
    ),
    st.builds(
        Suback,
        PACKET_ID,
        st.lists(st.sampled_from([ReasonCode.GRANTED_QOS_1, ReasonCode.NOT_AUTHORIZED]), min_size=1).map(tuple),
        properties_of(PacketType.SUBACK),
    ),
    st.builds(
        Unsubscribe,
        PACKET_ID,
        st.lists(FILTER, min_size=1, max_size=3).map(tuple),
        properties_of(PacketType.UNSUBSCRIBE),
    ),
    st.builds(Unsuback, PACKET_ID, st.just((ReasonCode.NO_SUBSCRIPTION_EXISTED,)), properties_of(PacketType.UNSUBACK)),
    st.builds(
        Disconnect, st.sampled_from([ReasonCode.SUCCESS, ReasonCode.BANNED]), properties_of(PacketType.DISCONNECT)
    ),
    st.builds(Auth, st.just(ReasonCode.REAUTHENTICATE), properties_of(PacketType.AUTH)),
)


@given(PACKETS)
def test_every_mqtt_5_packet_survives(packet: Packet) -> None:
    assert list(PacketReader(V5).feed(encode(packet, V5))) == [packet]


@given(QOS0 | QOS12, st.sampled_from([ProtocolVersion.V31, ProtocolVersion.V311]))
def test_a_message_survives_older_versions_without_its_properties(packet: Publish, version: ProtocolVersion) -> None:
    expected = packet._replace(properties=NO_PROPERTIES)
    assert list(PacketReader(version).feed(encode(packet, version))) == [expected]


def test_the_table_has_every_property_once() -> None:
    names = [row.name for row in _TABLE]
    assert sorted(names) == sorted(field.name for field in fields(Properties))
    assert len({row.number for row in _TABLE}) == len(_TABLE)


def test_a_message_may_carry_several_subscription_identifiers() -> None:
    properties = Properties(subscription_identifiers=(1, 300, 2**28 - 1))
    raw = encode_properties(properties, PacketType.PUBLISH)
    assert decode_properties(Cursor(raw), PacketType.PUBLISH) == properties
