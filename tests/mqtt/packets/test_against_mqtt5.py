"""Damaged messages against the mqtt5 package (Rust): where our codec accepts one, both read the same."""

import mqtt5
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.packets.test_every_type_against_mqtt5 import PACKETS

from homebot.mqtt.packets import Packet, PacketError, PacketReader, Publish, encode

pytestmark = pytest.mark.slow


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


@given(PACKETS["PUBLISH"], st.data())
def test_what_ours_accepts_of_a_damaged_message_theirs_reads_alike(packet: Packet, data: st.DataObject) -> None:
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
