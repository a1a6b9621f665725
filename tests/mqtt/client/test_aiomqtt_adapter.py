"""The promise of the port that the adapter of aiomqtt does not keep, and what is its own: paho and its thread."""

from random import Random

import anyio
import pytest
from paho.mqtt import client as paho
from paho.mqtt.enums import CallbackAPIVersion
from tests.mqtt.client.conftest import maker_of
from tests.mqtt.client.scripted_broker import Peer, broker

from homebot.clock import LoopClock
from homebot.errors import WireError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.native import ClientProtocol
from homebot.mqtt.client.paho_socket import PahoSocket
from homebot.mqtt.client.receiver import Frame, Receiver
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Disconnect, Puback, Publish, ReasonCode, Suback, Subscribe

make = maker_of(AiomqttClient)


async def test_qos_2_goes_out_as_qos_1_and_is_subscribed_to_as_it_is() -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        subscribe = await peer.expect(Subscribe)
        assert [wish.qos for wish in subscribe.filters] == [2]
        await peer.send(Suback(subscribe.packet_id, (ReasonCode.GRANTED_QOS_2,)))
        publish = await peer.expect(Publish)
        assert publish.qos == 1
        await peer.send(Puback(publish.packet_id or 0))
        await peer.expect(Disconnect)

    async with broker(script) as port, (client := make(port)).connected() as session:
        assert session.maximum_qos == 1
        assert await client.subscribe(MqttSubscription("t", 2)) == (2,)
        await client.publish("t", b"x", qos=2)


async def test_a_connection_that_is_given_up_while_a_thread_makes_it_is_closed() -> None:
    async def connect(client: MqttClient) -> None:
        async with client.connected():
            pytest.fail("nobody answered")

    async with broker(Peer.closed) as port, anyio.create_task_group() as tasks:
        tasks.start_soon(connect, make(port))
        await anyio.wait_all_tasks_blocked()
        tasks.cancel_scope.cancel()


async def test_paho_is_given_nothing_and_takes_nothing_before_it_may_speak() -> None:
    options = MqttOptions(host="127.0.0.1")
    link = ClientProtocol(options, "5", Receiver(options, LoopClock()), Requests(Random(1), 1.0))  # noqa: S311
    socket = PahoSocket(paho.Client(CallbackAPIVersion.VERSION2), options, None, link)
    with pytest.raises(WireError, match="before CONNECT"):
        socket.feed(Frame(0x20, b"\0\0\0"))
    with pytest.raises(ConnectionAbortedError):
        socket.send(b"x")
    with pytest.raises(BlockingIOError):
        socket.recv(1)
    assert socket.fileno() == -1
