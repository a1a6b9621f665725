"""A message survives a round trip in older versions; what each version writes is in test_golden."""

from __future__ import annotations

from dataclasses import fields

from hypothesis import given
from hypothesis import strategies as st
from tests.mqtt.packets.test_every_type_against_mqtt5 import PACKETS

from homebot.mqtt import packets as mqtt
from homebot.mqtt.packets.primitives import Cursor
from homebot.mqtt.packets.properties import _TABLE, decode_properties, encode_properties


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
