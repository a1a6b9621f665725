"""CONNECTs that MQTT 5 asks a server to refuse, beyond those of the Paho suite."""

import pytest
from tests.mqtt.broker.conformance.conftest import Meet

from homebot.mqtt.packets import ProtocolVersion, ReasonCode, encode


def test_authentication_data_without_a_method_is_a_protocol_error(meet: Meet) -> None:
    """MQTT 5.0, section 3.1.2.11.10."""
    client = meet(authentication_data=b"p")
    assert client.connack.reason is ReasonCode.PROTOCOL_ERROR
    assert client.client.link.closed


@pytest.mark.parametrize("client_id", ["a", ""])
def test_a_client_that_cannot_take_its_connack_is_refused(meet: Meet, client_id: str) -> None:
    """MQTT 5.0, section 3.1.2.11.4: nothing larger than the client's Maximum Packet Size may be sent to it."""
    welcome = len(encode(meet(client_id).connack, ProtocolVersion.V5))
    assert meet(client_id, maximum_packet_size=welcome).connack.reason is ReasonCode.SUCCESS
    refused = meet(client_id, maximum_packet_size=welcome - 1)
    assert refused.connack.reason is ReasonCode.PACKET_TOO_LARGE
    assert refused.client.link.closed


def test_a_client_refused_for_its_packet_size_leaves_the_session_of_its_namesake(meet: Meet) -> None:
    client = meet("a", session_expiry_interval=60)
    meet("a", maximum_packet_size=5)
    assert not client.client.link.closed
