"""The codec against another one: the mqtt5 package (Rust). Where ours accepts, both read the same."""

from __future__ import annotations

import mqtt5
import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.packets import (
    PacketError,
    PacketReader,
    Properties,
    Publish,
    encode,
)

pytestmark = pytest.mark.slow

TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0+#"), min_size=1, max_size=12)
PROPERTIES = st.builds(
    Properties,
    payload_format_indicator=st.none() | st.just(1),
    message_expiry_interval=st.none() | st.integers(0, 2**32 - 1),
    content_type=st.none() | TEXT,
    response_topic=st.none() | TEXT,
    correlation_data=st.none() | st.binary(max_size=9),
    topic_alias=st.none() | st.integers(1, 65_535),
    user_properties=st.lists(st.tuples(TEXT, TEXT), max_size=2).map(tuple),
)
PUBLISHES = st.builds(
    lambda topic, payload, qos, retain, packet_id, properties: Publish(
        topic, payload, qos, retain, False, packet_id if qos else None, properties
    ),
    TEXT,
    st.binary(max_size=200),
    st.integers(0, 2),
    st.booleans(),
    st.integers(1, 65_535),
    PROPERTIES,
)


def read(data: bytes) -> object | None:
    """What mqtt5 makes of *data*; None where it refuses, which it sometimes does by a panic."""
    try:
        return mqtt5.read(memoryview(data))[0]
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException:  # noqa: BLE001 - its panics are no Exception
        return None


def same(ours: Publish, theirs: object) -> bool:
    assert isinstance(theirs, mqtt5.PublishPacket)
    properties = ours.properties
    return (
        (ours.topic, ours.payload, ours.qos, ours.retain, ours.packet_id)
        == (theirs.topic, theirs.payload, theirs.qos, theirs.retain, theirs.packet_id)
        and (properties.payload_format_indicator or 0) == theirs.payload_format_indicator
        and properties.message_expiry_interval == theirs.message_expiry_interval
        and properties.content_type == theirs.content_type
        and properties.response_topic == theirs.response_topic
        and properties.correlation_data == theirs.correlation_data
        and properties.topic_alias == theirs.topic_alias
        and properties.user_properties == tuple(theirs.user_properties)
    )


@given(PUBLISHES)
def test_both_read_a_message_alike(packet: Publish) -> None:
    theirs = read(encode(packet))
    assert same(packet, theirs)
    assert isinstance(theirs, mqtt5.PublishPacket)
    assert list(PacketReader().feed(theirs.write())) == [packet]


@given(PUBLISHES, st.data())
def test_what_ours_accepts_of_a_damaged_message_theirs_reads_alike(packet: Publish, data: st.DataObject) -> None:
    raw = bytearray(encode(packet))
    for _ in range(data.draw(st.integers(1, 3))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    if raw[0] & 0xF0 != 0x30:
        return
    try:
        ours = PacketReader().feed(bytes(raw)).__next__()
    except (PacketError, StopIteration):
        return
    theirs = read(bytes(raw))
    assert theirs is None or (isinstance(ours, Publish) and same(ours, theirs))
