"""The promises of the port that the adapter of aiomqtt does not keep, and what it does instead."""

from __future__ import annotations

import pytest
from tests.mqtt.client.conftest import maker_of
from tests.mqtt.client.scripted_broker import Peer, broker

from homebot.errors import LinkError
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.packets import Connect, Disconnect, Puback, Publish, ReasonCode, Suback, Subscribe

make = maker_of(AiomqttClient)


async def test_qos_2_goes_out_and_is_subscribed_to_as_qos_1() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        subscribe = await peer.expect(Subscribe)
        assert [wish.qos for wish in subscribe.filters] == [1]
        await peer.send(Suback(subscribe.packet_id, (ReasonCode.GRANTED_QOS_1,)))
        publish = await peer.expect(Publish)
        assert publish.qos == 1
        await peer.send(Puback(publish.packet_id or 0))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected() as session:
        assert any("QoS 2" in limit for limit in client.limits)
        assert session.maximum_qos == 1
        assert await client.subscribe(MqttSubscription("t", 2)) == (1,)
        await client.publish("t", b"x", qos=2)


async def test_a_packet_that_mqtt_does_not_allow_ends_the_link() -> None:
    body = b"\x00\x01a\x00\x04\x02\x7f\x00"  # a PUBLISH with an unknown property

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send_raw(bytes([0x32, len(body)]) + body)
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        assert "unreadable" in str(await client.wait_lost())


@pytest.mark.parametrize(
    "nonsense", [b"\x15\x03\x01\x00\x02\x02\x46", b"HTTP/1.1 400 Bad Request\r\n\r\n", b"\xff" * 20]
)
async def test_what_speaks_no_mqtt_is_a_link_error_that_asks_for_tls(nonsense: bytes) -> None:
    async def strange(peer: Peer) -> None:
        await peer.expect(Connect)
        await peer.send_raw(nonsense)

    async with broker(strange, strange) as port:
        with pytest.raises(LinkError, match=r"instead of answering; is this a port for TLS"):
            async with make(port).connected():
                pass
