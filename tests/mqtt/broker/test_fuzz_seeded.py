"""Many damaged streams, fast and repeatable: ``make fuzz`` runs 100,000 of them, ``make test`` a few.

A case is made from the seed and its number alone, so a failure is repeated with ``make fuzz SEED=…``.
"""

import os
import random
import re

import pytest
from tests.fuzz.conftest import PARTS, SEED, Mutator
from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, Stranger

from homebot.mqtt import packets as mqtt

CASES = int(os.environ.get("FUZZ_CASES", "1000"))

# What may differ between two runs of one stream: an assigned client id, and the CONNACK for a CONNECT whose length
# alone is wrong, since it is sent only where the bytes that tell the version have come by then.
MAY_DIFFER = re.compile(rb"(?<=auto-)[0-9a-f]{32}|\A\x20\x03\x00[\x81\x95]\x00\Z")

TOPICS = ("t", "a/b", "", "$x", "a//b", "ü/" + "z" * 200)
FILTERS = ("#", "+/b", "t", "$share/g/t", "$share/g/+/+", "a/#", "$share/g")


@pytest.mark.parametrize("part", range(PARTS))
def test_a_damaged_stream_costs_its_own_connection_only(
    new_state: NewState, join: Join, stranger: Stranger, part: int
) -> None:
    for number in range(part, CASES, PARTS):
        rng = random.Random(f"{SEED}/{number}")  # noqa: S311 - nobody guesses at it
        version = rng.choice(list(mqtt.ProtocolVersion))
        logged_in = rng.random() < 0.7
        stream = make_stream(rng, version, starts_with_connect=not logged_in and rng.random() < 0.8)
        what = f"seed {SEED}, case {number}: {stream.hex()}"
        outcomes = []
        for pieces in ([stream], cut(rng, stream)):
            state = new_state(max_queued_messages=20, max_retained_messages=5, max_inflight=4, max_held_packets=8)
            witness = join("witness", at=state, to="$witness")
            client = stranger(version, at=state)
            if logged_in:
                client = join("wild", at=state, version=version, will=mqtt.Will("w"))
            try:
                outcomes.append(feed(client, pieces, logged_in=logged_in))
            except Exception as error:
                raise AssertionError(what) from error
            client.lose()
            witness.publish("$witness")
            assert [message.topic for message in witness.messages()] == ["$witness"], what
            assert state.stats.clients == 1, what
            assert state.stats.queued_messages <= 20, what
        assert outcomes[0] == outcomes[1], what


def feed(client: MemoryClient, pieces: list[bytes], *, logged_in: bool) -> tuple[bool, bytes]:
    """Send all and return whether the broker closed, and all it wrote; check how it said goodbye."""
    written = b""
    for piece in pieces:
        client.send_bytes(piece)
        written += bytes(client.link.written)
        client.link.written.clear()
    client.link.written += written
    if client.version is mqtt.ProtocolVersion.V5 and logged_in:
        goodbyes = [packet for packet in client.take() if isinstance(packet, mqtt.Disconnect)]
        assert len(goodbyes) == (client.link.closed and client.link.lingers)
        assert all(goodbye.reason.failed for goodbye in goodbyes)
    return client.link.closed, MAY_DIFFER.sub(b"", written)


def make_stream(rng: random.Random, version: mqtt.ProtocolVersion, *, starts_with_connect: bool) -> bytes:
    """Valid packets, some of them damaged, then perhaps anything."""
    packets: list[mqtt.Packet] = [make_connect(rng, version)] if starts_with_connect else []
    packets += [make_packet(rng) for _ in range(rng.randint(1, 6))]
    stream = bytearray()
    for packet in packets:
        raw = mqtt.encode(packet, version)
        if rng.random() < 0.5:
            raw = Mutator(rng).damaged_bytes(raw)
        stream += raw
    if rng.random() < 0.3:
        stream += rng.randbytes(rng.randint(1, 40))
    return bytes(stream) or b"\0"


def cut(rng: random.Random, stream: bytes) -> list[bytes]:
    cuts = sorted({rng.randrange(len(stream)) for _ in range(rng.choice((1, 2, 4, len(stream))))} - {0})
    return [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]


def make_connect(rng: random.Random, version: mqtt.ProtocolVersion) -> mqtt.Connect:
    properties = mqtt.Properties(session_expiry_interval=rng.choice((0, 9)), receive_maximum=rng.choice((1, 9)))
    return mqtt.Connect("wild", version, True, rng.choice((0, 5)), will=mqtt.Will("w", b"w", 1), properties=properties)


def make_packet(rng: random.Random) -> mqtt.Packet:
    packet_id = rng.choice((1, 2, 3, 65_535))
    if rng.random() < 0.4:
        qos = rng.randrange(3)
        properties = mqtt.Properties(
            topic_alias=rng.choice((None, 1, 64)),
            message_expiry_interval=rng.choice((None, 0, 9)),
            user_properties=rng.choice(((), (("k", "v"),))),
        )
        topic, payload = rng.choice(TOPICS), rng.randbytes(rng.choice((0, 1, 300)))
        return mqtt.Publish(topic, payload, qos, rng.random() < 0.3, False, packet_id if qos else None, properties)
    return rng.choice(
        (
            mqtt.Puback(packet_id),
            mqtt.Pubrec(packet_id),
            mqtt.Pubrel(packet_id),
            mqtt.Pubcomp(packet_id),
            mqtt.Subscribe(
                packet_id, tuple(mqtt.MqttSubscription(each, rng.randrange(3)) for each in rng.sample(FILTERS, 2))
            ),
            mqtt.Unsubscribe(packet_id, (rng.choice(FILTERS),)),
            mqtt.Pingreq(),
            mqtt.Disconnect(),
            mqtt.Connack(),
            mqtt.Suback(packet_id, ()),
        )
    )
