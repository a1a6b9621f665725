"""The incremental reader."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt import packets as mqtt

PACKETS: list[mqtt.Packet] = [
    mqtt.Publish("a/b", b"x" * 300, 1, packet_id=5),
    mqtt.Pingreq(),
    mqtt.Puback(7),
    mqtt.Publish("c", b""),
    mqtt.Publish("big", bytes(20_000)),
]


@given(st.lists(st.sampled_from(PACKETS), max_size=6), st.randoms(use_true_random=False))
def test_packets_come_out_whole_however_the_bytes_are_cut(packets: list[mqtt.Packet], random: Random) -> None:
    stream = b"".join(mqtt.encode(packet) for packet in packets)
    reader = mqtt.PacketReader()
    found: list[mqtt.Packet] = []
    while stream:
        size = random.choice((1, 2, 3, 50, 5000))
        found += reader.feed(stream[:size])
        stream = stream[size:]
    assert found == packets


def test_packets_not_taken_come_with_the_next_call() -> None:
    reader = mqtt.PacketReader()
    first = next(reader.feed(b"\xc0\x00\xc0\x00"))
    assert [first, *reader.feed(b"\xc0\x00")] == [mqtt.Pingreq()] * 3


def test_a_packet_that_is_too_large_is_refused_by_its_length_alone() -> None:
    reader = mqtt.PacketReader(max_packet_size=100)
    assert list(reader.feed(mqtt.encode(mqtt.Publish("a", bytes(94))))) == [mqtt.Publish("a", bytes(94))]
    with pytest.raises(mqtt.PacketError, match="101 bytes is too large") as caught:
        list(reader.feed(bytes.fromhex("30 63")))
    assert caught.value.code is mqtt.ReasonCode.PACKET_TOO_LARGE


def test_packets_before_a_bad_one_are_delivered_and_nothing_behind_it() -> None:
    reader = mqtt.PacketReader()
    packets = reader.feed(b"\xc0\x00\xc0\x01\x00\xc0\x00")
    assert next(packets) == mqtt.Pingreq()
    for _ in range(2):
        with pytest.raises(mqtt.PacketError):
            reader.pop()
    with pytest.raises(mqtt.PacketError):
        list(reader.feed(b"\xc0\x00"))
