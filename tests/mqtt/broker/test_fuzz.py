"""Any bytes from a client: that one connection ends with a reason, nothing is raised, the others are served."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.sizes import examples

from homebot.mqtt.packets import (
    Auth,
    Connect,
    Disconnect,
    FilterRequest,
    Packet,
    Pingreq,
    Properties,
    ProtocolVersion,
    Puback,
    Pubcomp,
    Publish,
    Pubrec,
    Pubrel,
    Subscribe,
    Unsubscribe,
    Will,
    encode,
)

if TYPE_CHECKING:
    from tests.mqtt.broker.conftest import Join, MemoryClient, NewState, Stranger

# Each example makes its own broker, so that what a fixture keeps between them does no harm.
FUZZ = settings(
    max_examples=examples(400),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

PACKETS: list[Packet] = [
    Connect("x", will=Will("w", b"w", 2, True, Properties(will_delay_interval=1))),
    Publish("t", b"hello"),
    Publish("t", b"hello", 1, packet_id=1, properties=Properties(topic_alias=1)),
    Publish("a/b", b"hello", 2, packet_id=2, retain=True, properties=Properties(message_expiry_interval=3)),
    Puback(1),
    Pubrec(1),
    Pubrel(2),
    Pubcomp(1),
    Subscribe(3, (FilterRequest("#", 2), FilterRequest("$share/g/t", 1))),
    Unsubscribe(4, ("#",)),
    Pingreq(),
    Disconnect(),
    Auth(),
]


@st.composite
def streams(draw: st.DrawFn, version: ProtocolVersion) -> list[bytes]:
    """Valid, damaged and random packets, cut into pieces anywhere."""
    stream = bytearray()
    for _ in range(draw(st.integers(1, 6))):
        packet = draw(st.sampled_from(PACKETS))
        raw = bytearray(b"\xf0\x00" if isinstance(packet, Auth) else encode(packet, version))
        for _ in range(draw(st.sampled_from((0, 0, 0, 1, 3)))):
            raw[draw(st.integers(0, len(raw) - 1))] = draw(st.integers(0, 255))
        stream += raw
    stream += draw(st.binary(max_size=20))
    cuts = sorted(draw(st.sets(st.integers(1, max(1, len(stream) - 1)), max_size=4)))
    return [bytes(stream[start:end]) for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]


def feed(client: MemoryClient, pieces: list[bytes]) -> None:
    for piece in pieces:
        client.send_bytes(piece)


@FUZZ
@given(data=st.data(), version=st.sampled_from(ProtocolVersion))
def test_a_client_that_has_logged_in_may_send_anything(
    new_state: NewState, join: Join, data: st.DataObject, version: ProtocolVersion
) -> None:
    state = new_state()
    witness = join("witness", at=state)
    witness.subscribe("$witness")
    client = join("wild", at=state, version=version, will=Will("w"))
    feed(client, data.draw(streams(version)))
    if client.link.closed and client.link.lingers and version is ProtocolVersion.V5:
        (goodbye,) = client.take_only(Disconnect)
        assert goodbye.reason.failed
    client.lose()
    witness.publish("$witness")
    assert [message.topic for message in witness.messages()] == ["$witness"]
    assert state.stats.clients == 1


@FUZZ
@given(data=st.data(), version=st.sampled_from(ProtocolVersion))
def test_a_stranger_may_send_anything(
    new_state: NewState, stranger: Stranger, join: Join, data: st.DataObject, version: ProtocolVersion
) -> None:
    state = new_state()
    client = stranger(version, at=state)
    feed(client, data.draw(streams(version) | st.lists(st.binary(min_size=1, max_size=30), min_size=1, max_size=3)))
    client.lose()
    witness = join("witness", at=state)
    witness.subscribe("$witness")
    witness.publish("$witness")
    assert len(witness.messages()) == 1
