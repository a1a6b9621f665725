"""Every type of packet against the mqtt5 package: it reads what we write, and we read what it writes as the same."""

import mqtt5
import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt import packets as mqtt

pytestmark = pytest.mark.slow

TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0+#$"), min_size=1, max_size=8)
BINARY = st.binary(max_size=8)
IDS = st.integers(1, 0xFFFF)
SECONDS = st.integers(1, 2**32 - 1)
PAIRS = st.lists(st.tuples(TEXT, TEXT), max_size=2).map(tuple)

# Values that are the default are left out by one side and written by the other, so they are not made here.
VALUES: dict[str, st.SearchStrategy[object]] = {
    "session_expiry_interval": SECONDS,
    "receive_maximum": st.integers(1, 0xFFFE),
    "maximum_packet_size": SECONDS,
    "topic_alias_maximum": IDS,
    "topic_alias": IDS,
    "server_keep_alive": IDS,
    "maximum_qos": st.integers(0, 1),
    "retain_available": st.just(0),
    "payload_format_indicator": st.just(1),
    "message_expiry_interval": st.integers(0, 2**32 - 1),
    "authentication_data": BINARY,
    "correlation_data": BINARY,
}


def words(names: str = "", **always: st.SearchStrategy[object]) -> st.SearchStrategy[mqtt.Properties]:
    """Properties: any of *names*, which are texts where nothing else is said, and *always* the others."""
    some = {name: st.none() | VALUES.get(name, TEXT) for name in names.split()}
    return st.builds(mqtt.Properties, user_properties=PAIRS, **some, **always)


def reasons(*codes: int) -> st.SearchStrategy[mqtt.ReasonCode]:
    return st.sampled_from([mqtt.ReasonCode(code) for code in codes])


def some(values: st.SearchStrategy[object]) -> st.SearchStrategy[tuple[object, ...]]:
    return st.lists(values, min_size=1, max_size=4).map(tuple)


PAYLOAD = st.binary(max_size=300)
PUBLISHED, RELEASED = reasons(0, 0x10, 0x87, 0x97), reasons(0, 0x92)
MESSAGE = words(
    "payload_format_indicator message_expiry_interval content_type response_topic correlation_data topic_alias"
)
PACKETS: dict[str, st.SearchStrategy[mqtt.Packet]] = {
    "CONNECT": st.builds(
        mqtt.Connect,
        TEXT,
        st.just(mqtt.ProtocolVersion.V5),
        st.booleans(),
        st.integers(0, 0xFFFF),
        st.none() | TEXT,
        st.none() | BINARY,
        st.none() | st.builds(mqtt.Will, TEXT, BINARY, st.integers(0, 2), st.booleans()),
        words(
            "session_expiry_interval receive_maximum maximum_packet_size topic_alias_maximum authentication_data",
            authentication_method=TEXT,
        ),
    ),
    "CONNACK": st.builds(
        mqtt.Connack,
        st.just(False),
        reasons(0, 0x86, 0x95),
        words(
            "session_expiry_interval receive_maximum maximum_qos retain_available maximum_packet_size"
            " assigned_client_identifier topic_alias_maximum reason_string server_keep_alive server_reference"
        ),
    ),
    "PUBLISH": st.builds(mqtt.Publish, TEXT, PAYLOAD, st.just(0), st.booleans(), st.just(False), st.none(), MESSAGE)
    | st.builds(mqtt.Publish, TEXT, PAYLOAD, st.integers(1, 2), st.booleans(), st.booleans(), IDS, MESSAGE),
    "PUBACK": st.builds(mqtt.Puback, IDS, PUBLISHED, words("reason_string")),
    "PUBREC": st.builds(mqtt.Pubrec, IDS, PUBLISHED, words("reason_string")),
    "PUBREL": st.builds(mqtt.Pubrel, IDS, RELEASED, words("reason_string")),
    "PUBCOMP": st.builds(mqtt.Pubcomp, IDS, RELEASED, words("reason_string")),
    "SUBSCRIBE": st.builds(
        mqtt.Subscribe,
        IDS,
        some(
            st.builds(mqtt.MqttSubscription, TEXT, st.integers(0, 2), st.booleans(), st.booleans(), st.integers(0, 2))
        ),
        words(subscription_identifiers=st.just(()) | st.tuples(st.integers(1, 2**28 - 1))),
    ),
    "SUBACK": st.builds(
        mqtt.Suback,
        IDS,
        some(reasons(0, 1, 2, 0x80, 0x83, 0x87, 0x8F, 0x97, 0x9E, 0xA2)),
        words("reason_string"),
    ),
    "UNSUBSCRIBE": st.builds(mqtt.Unsubscribe, IDS, some(TEXT), words()),
    "UNSUBACK": st.builds(mqtt.Unsuback, IDS, some(reasons(0, 0x11, 0x87)), words("reason_string")),
    "PINGREQ": st.just(mqtt.Pingreq()),
    "PINGRESP": st.just(mqtt.Pingresp()),
    "DISCONNECT": st.builds(
        mqtt.Disconnect, reasons(0, 0x04, 0x8E), words("session_expiry_interval reason_string server_reference")
    ),
    "AUTH": st.builds(
        mqtt.Auth, reasons(0x18, 0x19), words("authentication_data reason_string", authentication_method=TEXT)
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
