"""A message that is encoded once for all receivers alike."""

from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.broker.message import BULKY, BrokerMessage
from homebot.mqtt.packets import NO_PROPERTIES, PacketReader, Properties, ProtocolVersion, Publish


class Receiver(NamedTuple):
    version: ProtocolVersion
    qos: int
    retain: bool
    identifiers: tuple[int, ...]
    now: float


RECEIVERS = st.builds(
    Receiver,
    st.sampled_from(ProtocolVersion),
    st.integers(0, 2),
    st.booleans(),
    st.sampled_from([(), (1,), (1, 2)]),
    st.sampled_from([0.0, 5.0]),
)
PROPERTIES = st.sampled_from([NO_PROPERTIES, Properties(content_type="text")])


def received(message: BrokerMessage, receiver: Receiver) -> Publish:
    head, tail = message.parts(*receiver)
    packet_id = b"\0\7" if receiver.qos else b""
    (packet,) = PacketReader(receiver.version).feed(head + packet_id + tail)
    assert isinstance(packet, Publish)
    return packet


@given(st.lists(RECEIVERS, max_size=20), PROPERTIES, st.sampled_from([None, 60.0]))
def test_each_receiver_gets_its_own_form_whoever_was_served_before(
    receivers: list[Receiver], properties: Properties, expires_at: float | None
) -> None:
    """Version, QoS, retain flag, subscription identifiers and what is left of the expiry interval."""
    message = BrokerMessage("t", b"content", 2, True, properties, "p", expires_at)
    for receiver in receivers:
        version, qos, retain, identifiers, now = receiver
        expected = NO_PROPERTIES
        if version is ProtocolVersion.V5:
            expected = Properties(
                content_type=properties.content_type,
                subscription_identifiers=identifiers,
                message_expiry_interval=None if expires_at is None else int(expires_at - now),
            )
        assert received(message, receiver) == Publish(
            "t", b"content", qos, retain, packet_id=7 if qos else None, properties=expected
        )


@pytest.mark.parametrize("version", ProtocolVersion)
def test_the_bytes_are_made_once_for_receivers_alike(version: ProtocolVersion) -> None:
    message = BrokerMessage("t", b"content", 1)
    first = message.parts(version, 1, False)
    assert message.parts(version, 1, False) is first
    message.forget_encoded()
    assert message.parts(version, 1, False) is not first


def test_a_large_message_that_waits_is_not_kept_encoded() -> None:
    message = BrokerMessage("t", bytes(BULKY), 1)
    message.holders = 1
    message.parts(ProtocolVersion.V5, 1, False)
    assert message.kind == -1
    message.holders = 0
    message.parts(ProtocolVersion.V5, 1, False)
    assert message.kind != -1
